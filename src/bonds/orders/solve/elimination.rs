//! What is left of a problem while its variables are eliminated.

use super::Problem;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The scores of eliminated tables that are kept before room is made. Chosen: a few hundred kilobytes.
const MOST_WASTE: usize = 1 << 16;

/// Scores over several variables in ascending order; the last runs fastest.
#[derive(Debug, Clone, Copy)]
struct Table {
    is_gone: bool,
    /// Its part of the list of scopes.
    scope: (usize, usize),
    /// Its part of the list of scores.
    scores: (usize, usize),
}

/// An eliminated variable: its scope, and where its best states for every choice of that start.
#[derive(Debug, Clone, Copy)]
struct Answer {
    variable: u32,
    scope: (usize, usize),
    best: usize,
}

/// One table of the variable that is being eliminated.
#[derive(Debug, Clone, Copy)]
struct Own {
    /// The score at the present choice and the variable's first state.
    at: usize,
    /// From a state of the variable to the next.
    stride: usize,
}

/// An elimination; it may be run again for another problem.
#[derive(Default)]
pub(super) struct Elimination {
    unary: Vec<f32>,
    tables: Vec<Table>,
    /// The variables of tables and answers.
    scopes: Vec<u32>,
    /// The scores of tables.
    scores: Vec<f32>,
    /// How many of these are of tables that are not gone.
    live: usize,
    /// The tables of each variable; some may be gone.
    of: Vec<Vec<u32>>,
    /// Variables by [`Elimination::width`]; entries may be out of date.
    heap: BinaryHeap<Reverse<(usize, u32)>>,
    is_done: Vec<bool>,
    /// In the order of elimination.
    answers: Vec<Answer>,
    best: Vec<u8>,
    chosen: Vec<u8>,
    own: Vec<Own>,
    /// Steps of each own table from a state of each variable of the scope to the next.
    strides: Vec<usize>,
    choice: Vec<usize>,
    top: Vec<f32>,
}

impl Elimination {
    /// The states that the last run has chosen.
    pub(super) fn chosen(&self) -> &[u8] {
        &self.chosen
    }

    /// Eliminates all variables; `false` if a table or the sum of all would be too large and `may_settle` does not hold.
    pub(super) fn run(&mut self, problem: &Problem, largest: usize, most_work: usize, may_settle: bool) -> bool {
        self.start(problem);
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
            let now = self.entries(problem, scope);
            let cost = now.saturating_mul(problem.size(variable));
            work = work.saturating_add(cost);
            if cost > largest || work > most_work {
                if !may_settle {
                    return false;
                }
                self.settle(problem, variable, scope);
                continue;
            }
            self.eliminate(problem, variable, scope, now);
        }
        self.chosen.clear();
        self.chosen.resize(problem.count(), 0);
        for answer in self.answers.iter().rev() {
            let scope = &self.scopes[answer.scope.0..answer.scope.1];
            let step = |at: usize, &other: &u32| at * problem.size(other) + usize::from(self.chosen[other as usize]);
            let at = scope.iter().fold(0, step);
            self.chosen[answer.variable as usize] = self.best[answer.best + at];
        }
        true
    }

    fn start(&mut self, problem: &Problem) {
        let count = problem.count();
        self.unary.clone_from(&problem.unary);
        self.scores.clone_from(&problem.scores);
        self.live = self.scores.len();
        self.tables.clear();
        self.scopes.clear();
        for of in &mut self.of {
            of.clear();
        }
        if self.of.len() < count {
            self.of.resize(count, Vec::new());
        }
        for (index, pair) in problem.pairs.iter().enumerate() {
            let scope = self.scopes.len();
            self.scopes.extend([pair.a, pair.b]);
            let end = pair.at + problem.size(pair.a) * problem.size(pair.b);
            self.tables.push(Table { is_gone: false, scope: (scope, scope + 2), scores: (pair.at, end) });
            self.of[pair.a as usize].push(index as u32);
            self.of[pair.b as usize].push(index as u32);
        }
        self.heap.clear();
        self.is_done.clear();
        self.is_done.resize(count, false);
        self.answers.clear();
        self.best.clear();
        for variable in 0..count as u32 {
            // Alone: settled at once.
            match self.of[variable as usize].is_empty() {
                true => self.eliminate(problem, variable, (0, 0), 1),
                false => self.queue(variable),
            }
        }
    }

    /// The other variables in the tables of one, ascending, at the end of the list of scopes.
    fn scope(&mut self, variable: u32) -> (usize, usize) {
        let start = self.scopes.len();
        for &index in &self.of[variable as usize] {
            let table = self.tables[index as usize];
            for at in if table.is_gone { 0..0 } else { table.scope.0..table.scope.1 } {
                let other = self.scopes[at];
                if other != variable && !self.scopes[start..].contains(&other) {
                    self.scopes.push(other);
                }
            }
        }
        self.scopes[start..].sort_unstable();
        (start, self.scopes.len())
    }

    fn entries(&self, problem: &Problem, scope: (usize, usize)) -> usize {
        self.scopes[scope.0..scope.1]
            .iter()
            .fold(1, |entries: usize, &other| entries.saturating_mul(problem.size(other)))
    }

    /// How many variables a variable shares tables with, those of several tables counted as often.
    fn width(&self, variable: u32) -> usize {
        let tables = self.of[variable as usize].iter().map(|&index| self.tables[index as usize]);
        tables.filter(|table| !table.is_gone).map(|table| table.scope.1 - table.scope.0 - 1).sum()
    }

    fn queue(&mut self, variable: u32) {
        self.heap.push(Reverse((self.width(variable), variable)));
    }

    /// Replaces a variable by the best that it can do for every choice of its scope.
    fn eliminate(&mut self, problem: &Problem, variable: u32, scope: (usize, usize), entries: usize) {
        self.is_done[variable as usize] = true;
        self.list_own(problem, variable, scope);
        let best = self.best.len();
        self.maximise(problem, variable, scope, entries);
        for at in 0..self.of[variable as usize].len() {
            self.remove(self.of[variable as usize][at]);
        }
        self.of[variable as usize].clear();
        match self.scopes[scope.0..scope.1] {
            [] => {}
            [only] => {
                let states = problem.states(only);
                for (score, more) in self.unary[states].iter_mut().zip(&self.top) {
                    *score += more;
                }
            }
            _ => self.push_table(scope),
        }
        self.queue_all(scope, None);
        self.answers.push(Answer { variable, scope, best });
    }

    /// Lists the tables of a variable with their strides.
    fn list_own(&mut self, problem: &Problem, variable: u32, scope: (usize, usize)) {
        self.own.clear();
        self.strides.clear();
        for &index in &self.of[variable as usize] {
            let table = self.tables[index as usize];
            if table.is_gone {
                continue;
            }
            let of_table = &self.scopes[table.scope.0..table.scope.1];
            let stride = |wanted: u32| {
                let mut stride = 1;
                for &other in of_table.iter().rev() {
                    if other == wanted {
                        return stride;
                    }
                    stride *= problem.size(other);
                }
                0
            };
            self.own.push(Own { at: table.scores.0, stride: stride(variable) });
            self.strides.extend(self.scopes[scope.0..scope.1].iter().map(|&other| stride(other)));
        }
    }

    /// The best score of a variable into `top` and the state that gives it into `best`, for every choice of its scope.
    fn maximise(&mut self, problem: &Problem, variable: u32, scope: (usize, usize), entries: usize) {
        let unary = &self.unary[problem.states(variable)];
        let scope = &self.scopes[scope.0..scope.1];
        self.choice.clear();
        self.choice.resize(scope.len(), 0);
        self.top.clear();
        for _ in 0..entries {
            let (mut top, mut at) = (f32::NEG_INFINITY, 0u8);
            for (state, &own) in unary.iter().enumerate() {
                let mut score = own;
                for own in &self.own {
                    score += self.scores[own.at + state * own.stride];
                }
                if score > top {
                    (top, at) = (score, state as u8);
                }
            }
            self.top.push(top);
            self.best.push(at);
            // The next choice: the last variable runs fastest.
            for place in (0..scope.len()).rev() {
                self.choice[place] += 1;
                let carries = self.choice[place] == problem.size(scope[place]);
                for (table, own) in self.own.iter_mut().enumerate() {
                    let stride = self.strides[table * scope.len() + place];
                    own.at = if carries { own.at - stride * (self.choice[place] - 1) } else { own.at + stride };
                }
                if !carries {
                    break;
                }
                self.choice[place] = 0;
            }
        }
    }

    fn remove(&mut self, index: u32) {
        let table = &mut self.tables[index as usize];
        if !std::mem::replace(&mut table.is_gone, true) {
            self.live -= table.scores.1 - table.scores.0;
        }
    }

    /// A new table of the scores in `top`.
    fn push_table(&mut self, scope: (usize, usize)) {
        if self.scores.len() > 2 * self.live + self.tables.len() + MOST_WASTE {
            self.compact();
        }
        let at = self.scores.len();
        self.scores.extend_from_slice(&self.top);
        self.live += self.top.len();
        for &other in &self.scopes[scope.0..scope.1] {
            self.of[other as usize].push(self.tables.len() as u32);
        }
        self.tables.push(Table { is_gone: false, scope, scores: (at, self.scores.len()) });
    }

    /// Moves the scores of the tables that are left together.
    fn compact(&mut self) {
        let mut end = 0;
        for table in self.tables.iter_mut().filter(|table| !table.is_gone) {
            let (from, to) = table.scores;
            self.scores.copy_within(from..to, end);
            table.scores = (end, end + to - from);
            end = table.scores.1;
        }
        self.scores.truncate(end);
    }

    /// Puts the variables of a scope into the queue again, after their tables have changed.
    fn queue_all(&mut self, scope: (usize, usize), but: Option<u32>) {
        for at in scope.0..scope.1 {
            let other = self.scopes[at];
            if Some(other) != but {
                let tables = &self.tables;
                self.of[other as usize].retain(|&index| !tables[index as usize].is_gone);
                self.queue(other);
            }
        }
    }

    /// Settles a variable, or the one of its scope that has most tables, by what its tables say at their best.
    fn settle(&mut self, problem: &Problem, variable: u32, scope: (usize, usize)) {
        let around = self.scopes[scope.0..scope.1].iter().copied().chain([variable]);
        let settled = around.max_by_key(|&other| (self.width(other), Reverse(other))).unwrap_or(variable);
        let mut scores = self.unary[problem.states(settled)].to_vec();
        let mut indices = std::mem::take(&mut self.of[settled as usize]);
        indices.retain(|&index| !self.tables[index as usize].is_gone);
        for &index in &indices {
            let table = self.tables[index as usize];
            let of_table = &self.scopes[table.scope.0..table.scope.1];
            let place = of_table.iter().position(|&other| other == settled);
            let mut best = vec![f32::NEG_INFINITY; scores.len()];
            self.each(problem, table, |choice, score| {
                let beside = |(&other, &state): (&u32, &usize)| {
                    if other == settled { 0.0 } else { self.unary[problem.states(other).start + state] }
                };
                let score = score + of_table.iter().zip(choice).map(beside).sum::<f32>();
                let own = place.map_or(0, |place| choice[place]);
                best[own] = best[own].max(score);
            });
            for (score, best) in scores.iter_mut().zip(best) {
                *score += best;
            }
        }
        let state = (0..scores.len())
            .max_by(|&one, &other| scores[one].total_cmp(&scores[other]).then(other.cmp(&one)))
            .unwrap_or(0);
        self.is_done[settled as usize] = true;
        for index in indices {
            self.restrict(problem, index, settled, state);
        }
        self.answers.push(Answer { variable: settled, scope: (0, 0), best: self.best.len() });
        self.best.push(state as u8);
        self.queue_all(scope, Some(settled));
        if variable != settled {
            self.scopes.push(variable);
            self.queue_all((self.scopes.len() - 1, self.scopes.len()), None);
        }
    }

    /// Replaces a table by that of its other variables for one state of a settled one.
    fn restrict(&mut self, problem: &Problem, index: u32, settled: u32, state: usize) {
        let table = self.tables[index as usize];
        let of_table = &self.scopes[table.scope.0..table.scope.1];
        let place = of_table.iter().position(|&other| other == settled).unwrap_or(0);
        let rest: Vec<u32> = of_table.iter().copied().filter(|&other| other != settled).collect();
        let mut left = std::mem::take(&mut self.top);
        left.clear();
        self.each(problem, table, |choice, score| {
            if choice[place] == state {
                left.push(score);
            }
        });
        self.top = left;
        self.remove(index);
        match *rest {
            [only] => {
                let states = problem.states(only);
                for (score, more) in self.unary[states].iter_mut().zip(&self.top) {
                    *score += more;
                }
            }
            _ => {
                let start = self.scopes.len();
                self.scopes.extend(&rest);
                self.push_table((start, start + rest.len()));
            }
        }
    }

    /// Calls back with every choice of a table and its score, in the order of the scores.
    fn each(&self, problem: &Problem, table: Table, mut call: impl FnMut(&[usize], f32)) {
        let scope = &self.scopes[table.scope.0..table.scope.1];
        let mut choice = vec![0usize; scope.len()];
        for &score in &self.scores[table.scores.0..table.scores.1] {
            call(&choice, score);
            for (state, &other) in choice.iter_mut().zip(scope).rev() {
                *state += 1;
                if *state < problem.size(other) {
                    break;
                }
                *state = 0;
            }
        }
    }
}
