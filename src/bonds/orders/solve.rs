//! The cheapest choice of one state for every atom of a graph: exact by elimination of one atom after the other.
//!
//! Eliminating an atom replaces all that depends on it by a table over its neighbours: the best that the atom can do
//! for each of their choices. Molecules are nearly trees, so that these tables stay small. Where they would not (sheets
//! of graphene, fullerenes), some atoms are settled by what is best for them and their neighbours alone, and all others
//! are still chosen at best around them.
//!
//! A structure has thousands of such graphs, most of them of a few atoms: all lists are flat, and a [`Solver`] keeps its
//! memory from one graph to the next.

mod elimination;

use elimination::Elimination;

/// Entries of the largest table of an exact solution: drugs and proteins need at most a few thousand.
const LARGEST_TABLE: usize = 1 << 16;
/// Entries of all tables of an exact solution, by variable: more is a sheet or a cage.
const MOST_WORK: usize = 200;
/// Entries of the largest table where some atoms are settled beforehand: five carbons with four states each.
const LARGEST_TABLE_SETTLED: usize = 1 << 10;

/// A graph of choices. Scores are summed and the highest sum wins; −∞ forbids.
#[derive(Debug)]
pub(super) struct Problem {
    /// Scores of the states, one variable after the other.
    unary: Vec<f32>,
    /// The states of variable `i` are `first[i]..first[i + 1]`.
    first: Vec<u32>,
    pairs: Vec<Couple>,
    /// Scores of all pairs.
    scores: Vec<f32>,
}

/// Two variables `a < b` that depend on each other.
#[derive(Debug, Clone, Copy)]
struct Couple {
    a: u32,
    b: u32,
    /// Where the scores of their pairs of states start, `[state of a][state of b]`.
    at: usize,
}

impl Default for Problem {
    fn default() -> Self {
        Problem { unary: Vec::new(), first: vec![0], pairs: Vec::new(), scores: Vec::new() }
    }
}

impl Problem {
    /// Forgets everything but the memory.
    pub(super) fn clear(&mut self) {
        self.unary.clear();
        self.first.truncate(1);
        self.pairs.clear();
        self.scores.clear();
    }

    /// The next variable with the scores of its states.
    pub(super) fn push_variable(&mut self, scores: impl IntoIterator<Item = f32>) {
        self.unary.extend(scores);
        self.first.push(self.unary.len() as u32); // a few an atom
    }

    /// Two variables `a < b` that depend on each other; the scores of their pairs of states, `[state of a][state of b]`, are
    /// to follow.
    pub(super) fn push_pair(&mut self, a: u32, b: u32) {
        self.pairs.push(Couple { a, b, at: self.scores.len() });
    }

    /// More scores of the last pair.
    pub(super) fn push_scores(&mut self, scores: impl IntoIterator<Item = f32>) {
        self.scores.extend(scores);
    }

    /// The number of variables.
    fn count(&self) -> usize {
        self.first.len() - 1
    }

    /// The number of states of a variable.
    fn size(&self, variable: u32) -> usize {
        (self.first[variable as usize + 1] - self.first[variable as usize]) as usize
    }

    fn states(&self, variable: u32) -> std::ops::Range<usize> {
        self.first[variable as usize] as usize..self.first[variable as usize + 1] as usize
    }

    /// The scores of the states of a variable.
    pub(super) fn unary_mut(&mut self, variable: u32) -> &mut [f32] {
        let states = self.states(variable);
        &mut self.unary[states]
    }

    /// The scores of the pairs of states of two variables.
    fn scores(&self, pair: Couple) -> &[f32] {
        &self.scores[pair.at..pair.at + self.size(pair.a) * self.size(pair.b)]
    }

    /// The score of a choice.
    pub(super) fn score(&self, chosen: &[u8]) -> f32 {
        let own =
            chosen.iter().zip(&self.first).map(|(&state, &first)| self.unary[first as usize + usize::from(state)]);
        let pair = |&pair: &Couple| {
            let (one, other) = (usize::from(chosen[pair.a as usize]), usize::from(chosen[pair.b as usize]));
            self.scores[pair.at + one * self.size(pair.b) + other]
        };
        own.sum::<f32>() + self.pairs.iter().map(pair).sum::<f32>()
    }
}

/// What solving needs beside the problem.
#[derive(Default)]
pub(super) struct Solver {
    consistency: Consistency,
    small: Problem,
    elimination: Elimination,
    chosen: Vec<u8>,
}

impl Solver {
    /// The best states, or, where finding these would take too long, good ones.
    pub(super) fn solve(&mut self, problem: &Problem) -> &[u8] {
        self.consistency.find(problem);
        self.reduce(problem);
        let small = &self.small;
        let work = small.count().saturating_mul(MOST_WORK).max(8 * LARGEST_TABLE);
        let is_solved = self.elimination.run(small, LARGEST_TABLE, work, false)
            || self.elimination.run(small, LARGEST_TABLE_SETTLED, usize::MAX, true);
        self.chosen.clear();
        let found = self.elimination.chosen();
        let state = |variable: usize| {
            let chosen = if is_solved { found[variable] } else { 0 };
            self.consistency.of(variable).get(usize::from(chosen)).copied().unwrap_or(0)
        };
        self.chosen.extend((0..problem.count()).map(state));
        &self.chosen
    }

    /// The problem of the kept states; pairs of which one has a single state are counted with the other's.
    fn reduce(&mut self, problem: &Problem) {
        let (small, kept) = (&mut self.small, &self.consistency);
        small.clear();
        for variable in 0..problem.count() {
            let first = problem.first[variable] as usize;
            small.push_variable(kept.of(variable).iter().map(|&state| problem.unary[first + usize::from(state)]));
        }
        for &pair in &problem.pairs {
            let (one, other) = (kept.of(pair.a as usize), kept.of(pair.b as usize));
            let (scores, width) = (problem.scores(pair), problem.size(pair.b));
            let at = |one: u8, other: u8| scores[usize::from(one) * width + usize::from(other)];
            match (one, other) {
                (&[one], _) => {
                    for (score, &other) in small.unary_mut(pair.b).iter_mut().zip(other) {
                        *score += at(one, other);
                    }
                }
                (_, &[other]) => {
                    for (score, &one) in small.unary_mut(pair.a).iter_mut().zip(one) {
                        *score += at(one, other);
                    }
                }
                _ => {
                    small.pairs.push(Couple { at: small.scores.len(), ..pair });
                    for &one in one {
                        small.scores.extend(other.iter().map(|&other| at(one, other)));
                    }
                }
            }
        }
    }
}

/// The states of each variable that fit some state of each neighbour.
#[derive(Default)]
struct Consistency {
    alive: Vec<bool>,
    /// The pairs of variable `i` are `of[start[i]..start[i + 1]]`.
    start: Vec<u32>,
    of: Vec<u32>,
    queue: Vec<u32>,
    is_queued: Vec<bool>,
    /// The kept states of variable `i` are `kept[first[i]..first[i + 1]]`.
    kept: Vec<u8>,
    first: Vec<u32>,
}

impl Consistency {
    /// The kept states of a variable.
    fn of(&self, variable: usize) -> &[u8] {
        &self.kept[self.first[variable] as usize..self.first[variable + 1] as usize]
    }

    /// Strikes out one state after the other; where that leaves a variable none, all states of all are kept.
    fn find(&mut self, problem: &Problem) {
        self.alive.clear();
        self.alive.extend(problem.unary.iter().map(|score| score.is_finite()));
        self.list_pairs(problem);
        self.queue.clear();
        self.queue.extend((0..problem.pairs.len() as u32).rev());
        self.is_queued.clear();
        self.is_queued.resize(problem.pairs.len(), true);
        while let Some(index) = self.queue.pop() {
            self.is_queued[index as usize] = false;
            let pair = problem.pairs[index as usize];
            let scores = problem.scores(pair);
            let width = problem.size(pair.b);
            for (variable, other, stride, other_stride) in [(pair.a, pair.b, width, 1), (pair.b, pair.a, 1, width)] {
                let (own, beside) = (problem.states(variable), problem.states(other));
                let mut is_changed = false;
                for state in 0..own.len() {
                    let mut others = self.alive[beside.clone()].iter().enumerate();
                    let fits = |(beside, &alive): (usize, &bool)| {
                        alive && scores[state * stride + beside * other_stride].is_finite()
                    };
                    if self.alive[own.start + state] && !others.any(fits) {
                        self.alive[own.start + state] = false;
                        is_changed = true;
                    }
                }
                if is_changed {
                    let of = self.start[variable as usize] as usize..self.start[variable as usize + 1] as usize;
                    for &next in &self.of[of] {
                        if !std::mem::replace(&mut self.is_queued[next as usize], true) {
                            self.queue.push(next);
                        }
                    }
                }
            }
        }
        if !self.keep(problem, false) {
            self.keep(problem, true);
        }
    }

    /// Lists the pairs of each variable.
    fn list_pairs(&mut self, problem: &Problem) {
        self.start.clear();
        self.start.resize(problem.count() + 1, 0);
        for pair in &problem.pairs {
            self.start[pair.a as usize] += 1;
            self.start[pair.b as usize] += 1;
        }
        let mut sum = 0;
        for count in &mut self.start {
            sum += *count;
            *count = sum;
        }
        self.of.clear();
        self.of.resize(2 * problem.pairs.len(), 0);
        for (index, pair) in problem.pairs.iter().enumerate() {
            for variable in [pair.a, pair.b] {
                let slot = &mut self.start[variable as usize];
                *slot -= 1;
                self.of[*slot as usize] = index as u32;
            }
        }
    }

    /// Lists the states that are left, or all; `false` if a variable has none.
    fn keep(&mut self, problem: &Problem, all: bool) -> bool {
        self.kept.clear();
        self.first.clear();
        self.first.push(0);
        let mut has_each = true;
        for variable in 0..problem.count() as u32 {
            let before = self.kept.len();
            let states = problem.states(variable);
            let is_kept = |state: &u8| all || self.alive[states.start + usize::from(*state)];
            self.kept.extend((0..states.len() as u8).filter(is_kept));
            has_each &= self.kept.len() > before;
            self.first.push(self.kept.len() as u32);
        }
        has_each
    }
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
            problem.push_variable((0..states).map(|_| random(seed)));
        }
        let chords = (0..count / 2).map(|i| (i, i + count / 2));
        for (a, b) in (1..count).map(|i| (i - 1, i)).chain(std::iter::once((0, count - 1))).chain(chords) {
            let entries = problem.size(a) * problem.size(b);
            // The first states always fit.
            let score =
                |i: usize, seed: &mut u64| if i > 0 && random(seed) < 0.3 { f32::NEG_INFINITY } else { random(seed) };
            problem.push_pair(a, b);
            problem.push_scores((0..entries).map(|i| score(i, seed)));
        }
        problem
    }

    fn best_of_all(problem: &Problem) -> f32 {
        let mut chosen = vec![0u8; problem.count()];
        let mut best = f32::NEG_INFINITY;
        loop {
            best = best.max(problem.score(&chosen));
            let next = (0..chosen.len()).find(|&i| usize::from(chosen[i]) + 1 < problem.size(i as u32));
            let Some(next) = next else { return best };
            chosen[next] += 1;
            chosen[..next].fill(0);
        }
    }

    #[test]
    fn the_choice_is_the_best_of_all_with_one_solver_for_many_problems() {
        let mut seed = 1;
        let mut solver = Solver::default();
        for round in 0..60 {
            let problem = problem(4 + round % 4, &mut seed);
            let score = problem.score(solver.solve(&problem));
            assert!((score - best_of_all(&problem)).abs() < 1e-4, "{score}");
        }
    }

    #[test]
    fn settling_some_beforehand_still_gives_a_choice_that_fits() {
        let mut seed = 2;
        let mut elimination = Elimination::default();
        for _ in 0..40 {
            let problem = problem(8, &mut seed);
            assert!(elimination.run(&problem, 16, usize::MAX, true));
            assert_eq!(elimination.chosen().len(), 8);
            let best = best_of_all(&problem);
            assert!(problem.score(elimination.chosen()) <= best + 1e-4);
        }
    }
}
