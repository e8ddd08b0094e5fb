//! Rays of direct light in turns, so that a frame traces but a share of them.

/// Which rays, and which blocks of surfels, have their turn in a frame: every n-th.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShadowTurn {
    /// Number of the turn, below `turns`.
    pub turn: usize,
    /// Turns until all have had theirs, at least one.
    pub turns: usize,
}

impl ShadowTurn {
    /// All at once.
    pub const ALL: Self = Self { turn: 0, turns: 1 };

    /// Whether it is the turn of the one with this number.
    pub(crate) fn has(self, number: usize) -> bool {
        number % self.turns == self.turn
    }

    /// Turns until all is as if nothing had taken turns: those of all rays, then those of all blocks of surfels in which each
    /// finds how much of it is hidden, then those in which each takes that of all others into account. Each begins with the
    /// last turn of the one before.
    pub(crate) fn until_settled(self) -> usize {
        3 * (self.turns - 1) + 1
    }

    /// Whether rays are still to be traced when so many turns are left.
    pub(crate) fn are_rays_due(self, left: usize) -> bool {
        left > 2 * (self.turns - 1)
    }

    /// Numbers of those whose turn it is.
    pub(crate) fn of(self, count: usize) -> impl Iterator<Item = usize> {
        (self.turn..count).step_by(self.turns)
    }
}

/// How many turns are left until all rays know the present lights and objects.
#[derive(Clone, Debug, Default)]
pub(crate) struct ShadowTurns {
    lights: u32,
    objects: u32,
    turn: usize,
    /// Whether some frame had all rays at once since the last that was asked to.
    has_begun: bool,
}

/// What direct light a frame finds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShadowWork {
    /// The rays whose turn it is.
    pub turn: ShadowTurn,
    /// Whether they meet what stands still anew.
    pub lights: bool,
    /// Whether they meet objects anew.
    pub objects: bool,
}

impl ShadowTurns {
    /// Makes the next frame leave nothing to later turns.
    pub(crate) fn all_at_once(&mut self) {
        self.has_begun = false;
    }

    /// What is to be done in a frame in which lights or objects may have moved.
    pub(crate) fn next(&mut self, turns: u32, lights_moved: bool, objects_moved: bool) -> ShadowWork {
        let turns = if std::mem::replace(&mut self.has_begun, true) { turns } else { 1 };
        let until_settled = ShadowTurn { turn: 0, turns: turns as usize }.until_settled() as u32;
        if lights_moved {
            self.lights = until_settled;
        }
        if objects_moved {
            self.objects = until_settled;
        }
        let work = ShadowWork { turn: ShadowTurn::ALL, lights: self.lights > 0, objects: self.objects > 0 };
        if turns == 1 {
            (self.lights, self.objects) = (0, 0);
            return work;
        }
        (self.lights, self.objects) = (self.lights.saturating_sub(1), self.objects.saturating_sub(1));
        self.turn = (self.turn + 1) % turns as usize;
        ShadowWork { turn: ShadowTurn { turn: self.turn, turns: turns as usize }, ..work }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn has_work(work: ShadowWork) -> bool {
        work.lights || work.objects
    }

    const ALL_LIGHTS: ShadowWork = ShadowWork { turn: ShadowTurn::ALL, lights: true, objects: false };

    #[test]
    fn all_rays_have_a_turn_after_the_last_change() {
        let mut turns = ShadowTurns::default();
        assert_eq!(turns.next(4, true, false), ALL_LIGHTS, "the first frame knows nothing yet");
        assert!(!has_work(turns.next(4, false, false)));
        let mut seen = vec![turns.next(4, true, false)];
        seen.extend((0..12).map(|_| turns.next(4, false, false)));
        let turns: Vec<usize> = seen.iter().filter(|work| work.lights).map(|work| work.turn.turn).collect();
        for part in [&turns[..4], &turns[3..7], &turns[6..]] {
            let mut sorted = part.to_vec();
            sorted.sort_unstable();
            assert_eq!(sorted, [0, 1, 2, 3], "first all rays, then twice all surfels: {turns:?}");
        }
        assert!(seen.iter().all(|work| !work.objects && work.turn.turns == 4));
    }

    #[test]
    fn what_is_left_is_made_up_for_when_asked_to() {
        let mut turns = ShadowTurns::default();
        turns.next(4, true, true);
        turns.next(4, true, false);
        turns.all_at_once();
        assert_eq!(turns.next(4, false, false), ALL_LIGHTS);
        assert!(!has_work(turns.next(4, false, false)));
        // With one turn there is nothing left ever.
        assert_eq!(turns.next(1, true, false), ALL_LIGHTS);
        assert!(!has_work(turns.next(1, false, false)));
    }
}
