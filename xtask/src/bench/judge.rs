//! Equal answers: every place on which two methods differ is decided exactly, one by one.

use std::fmt;

use serde::Serialize;

/// Whose answers were wrong where they differed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub(super) struct Verdicts {
    /// Places with different answers.
    pub(super) differing: u64,
    /// Those of them that the own side answered wrongly; there must be none.
    pub(super) own_wrong: u64,
}

/// Compares two lists of answers; `is_lit` decides one place exactly.
pub(super) fn judge(own: &[bool], peer: &[bool], is_lit: impl Fn(usize) -> bool) -> Verdicts {
    let mut verdicts = Verdicts::default();
    for (index, (own, _)) in own.iter().zip(peer).enumerate().filter(|(_, (own, peer))| own != peer) {
        verdicts.differing += 1;
        verdicts.own_wrong += u64::from(*own != is_lit(index));
    }
    verdicts
}

impl fmt::Display for Verdicts {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{}, own wrong: {}", self.differing, self.own_wrong)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_differences_are_decided() {
        let truth = [true, false, true, true];
        let (own, peer) = ([true, false, true, false], [true, true, false, true]);
        let verdicts = judge(&own, &peer, |index| truth[index]);
        assert_eq!(verdicts, Verdicts { differing: 3, own_wrong: 1 });
    }
}
