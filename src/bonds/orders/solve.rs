//! The cheapest choice of one state for every atom of a graph: exact by elimination of one atom after the other.
//!
//! Eliminating an atom replaces all that depends on it by a table over its neighbours: the best that the atom can do
//! for each of their choices. Molecules are nearly trees, so that these tables stay small. Where they would not (sheets
//! of graphene, fullerenes), some atoms are settled by what is best for them and their neighbours alone, and all others
//! are still chosen at best around them.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Entries of the largest table of an exact solution: drugs and proteins need at most a few thousand.
const LARGEST_TABLE: usize = 1 << 16;
/// Entries of all tables of an exact solution, by variable: more is a sheet or a cage.
const MOST_WORK: usize = 200;
/// Entries of the largest table where some atoms are settled beforehand: five carbons with four states each.
const LARGEST_TABLE_SETTLED: usize = 1 << 10;

/// A graph of choices. Scores are summed and the highest sum wins; −∞ forbids.
#[derive(Debug, Default)]
pub(super) struct Problem {
    /// Scores of the states of each variable.
    pub(super) unary: Vec<Vec<f32>>,
    /// Two variables `a < b` and the scores of their pairs of states, `[state of a][state of b]`.
    pub(super) pairs: Vec<(u32, u32, Vec<f32>)>,
}

/// Scores over several variables in ascending order; the last runs fastest.
struct Table {
    scope: Vec<u32>,
    scores: Vec<f32>,
}

impl Problem {
    /// The best states, or, where finding these would take too long, good ones.
    pub(super) fn solve(&self) -> Vec<u8> {
        let kept = self.consistent();
        let small = self.reduced(&kept);
        let work = small.unary.len().saturating_mul(MOST_WORK).max(8 * LARGEST_TABLE);
        let chosen = Elimination::new(&small).run(LARGEST_TABLE, work, false).unwrap_or_else(|| {
            let settled = Elimination::new(&small).run(LARGEST_TABLE_SETTLED, usize::MAX, true);
            settled.unwrap_or_else(|| vec![0; small.unary.len()])
        });
        let state = |(kept, chosen): (&Vec<u8>, &u8)| kept.get(usize::from(*chosen)).copied().unwrap_or(0);
        kept.iter().zip(&chosen).map(state).collect()
    }

    /// The score of a choice.
    pub(super) fn score(&self, chosen: &[u8]) -> f32 {
        let own = self.unary.iter().zip(chosen).map(|(unary, &state)| unary[usize::from(state)]);
        let pair = |(a, b, scores): &(u32, u32, Vec<f32>)| {
            let (one, other) = (usize::from(chosen[*a as usize]), usize::from(chosen[*b as usize]));
            scores[one * self.unary[*b as usize].len() + other]
        };
        own.sum::<f32>() + self.pairs.iter().map(pair).sum::<f32>()
    }

    /// The states of each variable that fit some state of each neighbour, found by striking out one after the other; all
    /// states where that leaves none.
    fn consistent(&self) -> Vec<Vec<u8>> {
        let mut alive: Vec<Vec<bool>> =
            self.unary.iter().map(|scores| scores.iter().map(|score| score.is_finite()).collect()).collect();
        let mut of: Vec<Vec<u32>> = vec![Vec::new(); self.unary.len()];
        for (index, (a, b, _)) in self.pairs.iter().enumerate() {
            of[*a as usize].push(index as u32);
            of[*b as usize].push(index as u32);
        }
        let mut queue: Vec<u32> = (0..self.pairs.len() as u32).rev().collect();
        let mut is_queued = vec![true; self.pairs.len()];
        while let Some(index) = queue.pop() {
            is_queued[index as usize] = false;
            let (a, b, scores) = &self.pairs[index as usize];
            let (a, b) = (*a as usize, *b as usize);
            let width = self.unary[b].len();
            for (variable, other, stride, other_stride) in [(a, b, width, 1), (b, a, 1, width)] {
                let mut is_changed = false;
                for state in 0..self.unary[variable].len() {
                    let fits = |(beside, &alive): (usize, &bool)| {
                        alive && scores[state * stride + beside * other_stride].is_finite()
                    };
                    if alive[variable][state] && !alive[other].iter().enumerate().any(fits) {
                        alive[variable][state] = false;
                        is_changed = true;
                    }
                }
                if is_changed {
                    for &next in &of[variable] {
                        if !std::mem::replace(&mut is_queued[next as usize], true) {
                            queue.push(next);
                        }
                    }
                }
            }
        }
        let kept = |alive: &Vec<bool>| (0..alive.len() as u8).filter(|&state| alive[usize::from(state)]).collect();
        let kept: Vec<Vec<u8>> = alive.iter().map(kept).collect();
        if kept.iter().any(Vec::is_empty) {
            return self.unary.iter().map(|scores| (0..scores.len() as u8).collect()).collect();
        }
        kept
    }

    /// The problem of the kept states; pairs of which one has a single state are counted with the other's.
    fn reduced(&self, kept: &[Vec<u8>]) -> Problem {
        let unary = self.unary.iter().zip(kept);
        let mut small = Problem {
            unary: unary.map(|(scores, kept)| kept.iter().map(|&state| scores[usize::from(state)]).collect()).collect(),
            pairs: Vec::with_capacity(self.pairs.len()),
        };
        for (a, b, scores) in &self.pairs {
            let (one, other) = (&kept[*a as usize], &kept[*b as usize]);
            let width = self.unary[*b as usize].len();
            let at = |one: u8, other: u8| scores[usize::from(one) * width + usize::from(other)];
            match (one.as_slice(), other.as_slice()) {
                (&[one], _) => {
                    for (score, &other) in small.unary[*b as usize].iter_mut().zip(other) {
                        *score += at(one, other);
                    }
                }
                (_, &[other]) => {
                    for (score, &one) in small.unary[*a as usize].iter_mut().zip(one) {
                        *score += at(one, other);
                    }
                }
                _ => {
                    let scores = one.iter().flat_map(|&one| other.iter().map(move |&other| (one, other)));
                    small.pairs.push((*a, *b, scores.map(|(one, other)| at(one, other)).collect()));
                }
            }
        }
        small
    }
}

/// What is left of a problem while its variables are eliminated.
struct Elimination<'p> {
    problem: &'p Problem,
    unary: Vec<Vec<f32>>,
    tables: Vec<Option<Table>>,
    /// The tables of each variable; some may be gone.
    of: Vec<Vec<u32>>,
    /// Variables by [`Elimination::width`]; entries may be out of date.
    heap: BinaryHeap<Reverse<(usize, u32)>>,
    is_done: Vec<bool>,
    /// In the order of elimination: the variable, its scope, and its best state for every choice of that.
    answers: Vec<(u32, Vec<u32>, Vec<u8>)>,
}

impl<'p> Elimination<'p> {
    fn new(problem: &'p Problem) -> Elimination<'p> {
        let count = problem.unary.len();
        let mut of: Vec<Vec<u32>> = vec![Vec::new(); count];
        for (index, (a, b, _)) in problem.pairs.iter().enumerate() {
            of[*a as usize].push(index as u32);
            of[*b as usize].push(index as u32);
        }
        let table = |(a, b, scores): &(u32, u32, Vec<f32>)| Some(Table { scope: vec![*a, *b], scores: scores.clone() });
        let mut elimination = Elimination {
            problem,
            unary: problem.unary.clone(),
            tables: problem.pairs.iter().map(table).collect(),
            of,
            heap: BinaryHeap::with_capacity(count),
            is_done: vec![false; count],
            answers: Vec::with_capacity(count),
        };
        for variable in 0..count as u32 {
            match *elimination.of[variable as usize] {
                // Alone: settled at once.
                [] => elimination.eliminate(variable, Vec::new(), 1),
                _ => elimination.queue(variable),
            }
        }
        elimination
    }

    fn size(&self, variable: u32) -> usize {
        self.problem.unary[variable as usize].len()
    }

    /// The other variables in the tables of one, ascending.
    fn scope(&self, variable: u32) -> Vec<u32> {
        let mut scope: Vec<u32> = Vec::new();
        for table in self.of[variable as usize].iter().filter_map(|&index| self.tables[index as usize].as_ref()) {
            scope.extend(table.scope.iter().filter(|&&other| other != variable));
        }
        scope.sort_unstable();
        scope.dedup();
        scope
    }

    fn entries(&self, scope: &[u32]) -> usize {
        scope.iter().fold(1usize, |entries, &other| entries.saturating_mul(self.size(other)))
    }

    /// How many variables a variable shares tables with, those of several tables counted as often.
    fn width(&self, variable: u32) -> usize {
        let tables = self.of[variable as usize].iter().filter_map(|&index| self.tables[index as usize].as_ref());
        tables.map(|table| table.scope.len() - 1).sum()
    }

    fn queue(&mut self, variable: u32) {
        self.heap.push(Reverse((self.width(variable), variable)));
    }

    /// Eliminates all variables; `None` if a table or the sum of all would be too large and `may_settle` does not hold.
    fn run(mut self, largest: usize, most_work: usize, may_settle: bool) -> Option<Vec<u8>> {
        let mut work = 0usize;
        while let Some(Reverse((width, variable))) = self.heap.pop() {
            if self.is_done[variable as usize] {
                continue;
            }
            let now = self.width(variable);
            if now > width {
                self.heap.push(Reverse((now, variable)));
                continue;
            }
            let scope = self.scope(variable);
            let now = self.entries(&scope);
            let cost = now.saturating_mul(self.size(variable));
            work = work.saturating_add(cost);
            if cost > largest || work > most_work {
                if !may_settle {
                    return None;
                }
                self.settle(variable, &scope);
                continue;
            }
            self.eliminate(variable, scope, now);
        }
        let mut chosen = vec![0u8; self.unary.len()];
        for (variable, scope, best) in self.answers.iter().rev() {
            let at = scope.iter().fold(0, |at, &other| at * self.size(other) + usize::from(chosen[other as usize]));
            chosen[*variable as usize] = best[at];
        }
        Some(chosen)
    }

    fn eliminate(&mut self, variable: u32, scope: Vec<u32>, entries: usize) {
        self.is_done[variable as usize] = true;
        let indices = std::mem::take(&mut self.of[variable as usize]);
        let own: Vec<Table> = indices.into_iter().filter_map(|index| self.tables[index as usize].take()).collect();
        let (scores, best) =
            eliminate(variable, &self.unary[variable as usize], &own, &scope, &|other| self.size(other), entries);
        match *scope {
            [] => {}
            [only] => {
                for (score, more) in self.unary[only as usize].iter_mut().zip(scores) {
                    *score += more;
                }
            }
            _ => self.push_table(Table { scope: scope.clone(), scores }),
        }
        for &other in &scope {
            let tables = &self.tables;
            self.of[other as usize].retain(|&index| tables[index as usize].is_some());
            self.queue(other);
        }
        self.answers.push((variable, scope, best));
    }

    fn push_table(&mut self, table: Table) {
        for &other in &table.scope {
            self.of[other as usize].push(self.tables.len() as u32);
        }
        self.tables.push(Some(table));
    }

    /// Settles a variable, or the one of its scope that has most tables, by what its tables say at their best.
    fn settle(&mut self, variable: u32, scope: &[u32]) {
        let tables =
            |other: u32| self.of[other as usize].iter().filter(|&&index| self.tables[index as usize].is_some());
        let widest = scope.iter().copied().chain([variable]).max_by_key(|&other| (self.width(other), Reverse(other)));
        let settled = widest.unwrap_or(variable);
        let mut scores = self.unary[settled as usize].clone();
        let indices: Vec<u32> = tables(settled).copied().collect();
        for table in indices.iter().filter_map(|&index| self.tables[index as usize].as_ref()) {
            let mut best = vec![f32::NEG_INFINITY; scores.len()];
            table.each(&|other| self.size(other), |choice, score| {
                let beside = |(&other, &state): (&u32, &usize)| {
                    if other == settled { 0.0 } else { self.unary[other as usize][state] }
                };
                let score = score + table.scope.iter().zip(choice).map(beside).sum::<f32>();
                let own = table.scope.iter().position(|&other| other == settled).map_or(0, |place| choice[place]);
                best[own] = best[own].max(score);
            });
            for (score, best) in scores.iter_mut().zip(best) {
                *score += best;
            }
        }
        let best = (0..scores.len())
            .max_by(|&one, &other| scores[one].total_cmp(&scores[other]).then(other.cmp(&one)))
            .unwrap_or(0);
        self.is_done[settled as usize] = true;
        self.of[settled as usize].clear();
        for index in indices {
            let Some(table) = self.tables[index as usize].take() else { continue };
            let rest: Vec<u32> = table.scope.iter().copied().filter(|&other| other != settled).collect();
            let place = table.scope.iter().position(|&other| other == settled).unwrap_or(0);
            let mut left = Vec::with_capacity(self.entries(&rest));
            table.each(&|other| self.size(other), |choice, score| {
                if choice[place] == best {
                    left.push(score);
                }
            });
            match *rest {
                [only] => {
                    for (score, more) in self.unary[only as usize].iter_mut().zip(left) {
                        *score += more;
                    }
                }
                _ => self.push_table(Table { scope: rest, scores: left }),
            }
        }
        self.answers.push((settled, Vec::new(), vec![best as u8]));
        for &other in scope.iter().chain([&variable]).filter(|&&other| other != settled) {
            let tables = &self.tables;
            self.of[other as usize].retain(|&index| tables[index as usize].is_some());
            self.queue(other);
        }
    }
}

impl Table {
    /// Calls back with every choice and its score, in the order of the scores.
    fn each(&self, size: &impl Fn(u32) -> usize, mut call: impl FnMut(&[usize], f32)) {
        let mut choice = vec![0usize; self.scope.len()];
        for &score in &self.scores {
            call(&choice, score);
            for (state, &other) in choice.iter_mut().zip(&self.scope).rev() {
                *state += 1;
                if *state < size(other) {
                    break;
                }
                *state = 0;
            }
        }
    }
}

/// The best score of a variable and the state that gives it for every choice of its scope.
fn eliminate(
    variable: u32,
    unary: &[f32],
    tables: &[Table],
    scope: &[u32],
    size: &impl Fn(u32) -> usize,
    entries: usize,
) -> (Vec<f32>, Vec<u8>) {
    // Strides of the scope's variables and of the own one in each table.
    let strides: Vec<(Vec<usize>, usize)> = tables
        .iter()
        .map(|table| {
            let stride = |wanted: u32| {
                let mut stride = 1;
                for &other in table.scope.iter().rev() {
                    if other == wanted {
                        return stride;
                    }
                    stride *= size(other);
                }
                0
            };
            (scope.iter().map(|&other| stride(other)).collect(), stride(variable))
        })
        .collect();
    let mut choice = vec![0usize; scope.len()];
    let mut bases = vec![0usize; tables.len()];
    let (mut scores, mut best) = (Vec::with_capacity(entries), Vec::with_capacity(entries));
    for _ in 0..entries {
        let (mut top, mut at) = (f32::NEG_INFINITY, 0u8);
        for (state, &own) in unary.iter().enumerate() {
            let mut score = own;
            for ((table, base), (_, stride)) in tables.iter().zip(&bases).zip(&strides) {
                score += table.scores[base + state * stride];
            }
            if score > top {
                (top, at) = (score, state as u8);
            }
        }
        scores.push(top);
        best.push(at);
        // The next choice: the last variable runs fastest.
        for place in (0..scope.len()).rev() {
            choice[place] += 1;
            let carries = choice[place] == size(scope[place]);
            for (base, (stride, _)) in bases.iter_mut().zip(&strides) {
                *base = if carries { *base - stride[place] * (choice[place] - 1) } else { *base + stride[place] };
            }
            if !carries {
                break;
            }
            choice[place] = 0;
        }
    }
    (scores, best)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random(seed: &mut u64) -> f32 {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 40) as f32 / (1u64 << 24) as f32
    }

    /// A ring of variables with some chords and some forbidden pairs.
    fn problem(count: u32, seed: &mut u64) -> Problem {
        let mut problem = Problem::default();
        for _ in 0..count {
            let states = 2 + (random(seed) * 3.0) as usize;
            problem.unary.push((0..states).map(|_| random(seed)).collect());
        }
        let chords = (0..count / 2).map(|i| (i, i + count / 2));
        for (a, b) in (1..count).map(|i| (i - 1, i)).chain(std::iter::once((0, count - 1))).chain(chords) {
            let entries = problem.unary[a as usize].len() * problem.unary[b as usize].len();
            // The first states always fit.
            let score =
                |i: usize, seed: &mut u64| if i > 0 && random(seed) < 0.3 { f32::NEG_INFINITY } else { random(seed) };
            problem.pairs.push((a, b, (0..entries).map(|i| score(i, seed)).collect()));
        }
        problem
    }

    fn best_of_all(problem: &Problem) -> f32 {
        let mut chosen = vec![0u8; problem.unary.len()];
        let mut best = f32::NEG_INFINITY;
        loop {
            best = best.max(problem.score(&chosen));
            let next = (0..chosen.len()).find(|&i| usize::from(chosen[i]) + 1 < problem.unary[i].len());
            let Some(next) = next else { return best };
            chosen[next] += 1;
            chosen[..next].fill(0);
        }
    }

    #[test]
    fn the_choice_is_the_best_of_all() {
        let mut seed = 1;
        for _ in 0..40 {
            let problem = problem(7, &mut seed);
            let score = problem.score(&problem.solve());
            assert!((score - best_of_all(&problem)).abs() < 1e-4, "{score}");
        }
    }

    #[test]
    fn settling_some_beforehand_still_gives_a_choice_that_fits() {
        let mut seed = 2;
        for _ in 0..40 {
            let problem = problem(8, &mut seed);
            let chosen = Elimination::new(&problem).run(16, usize::MAX, true).unwrap();
            assert_eq!(chosen.len(), 8);
            let best = best_of_all(&problem);
            assert!(problem.score(&chosen) <= best + 1e-4);
        }
    }
}
