//! Which services are fuzzed.

use std::fmt;
use std::str::FromStr;

/// A service, or all services, to fuzz.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum Target {
    /// The SDO server.
    Sdo,
    /// The LSS slave.
    Lss,
    /// NMT and error control.
    Nmt,
    /// PDOs and their configuration.
    Pdo,
    /// SYNC, EMCY, heartbeat consumer.
    SyncEmcy,
    /// All services, interleaved.
    #[default]
    All,
}

impl Target {
    /// All targets.
    pub const ALL: [Self; 6] = [Self::Sdo, Self::Lss, Self::Nmt, Self::Pdo, Self::SyncEmcy, Self::All];

    /// All services with their relative frequencies. The SDO server has by far the most states.
    const SHARES: [(Self, usize); 5] =
        [(Self::Sdo, 6), (Self::Pdo, 2), (Self::Nmt, 1), (Self::SyncEmcy, 1), (Self::Lss, 2)];

    /// The name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sdo => "sdo",
            Self::Lss => "lss",
            Self::Nmt => "nmt",
            Self::Pdo => "pdo",
            Self::SyncEmcy => "sync-emcy",
            Self::All => "all",
        }
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// No target has this name.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("no target is called \"{0}\": expected sdo, lss, nmt, pdo, sync-emcy or all, or a list such as sdo,lss")]
pub struct UnknownTarget(pub String);

impl FromStr for Target {
    type Err = UnknownTarget;

    fn from_str(name: &str) -> Result<Self, UnknownTarget> {
        Self::ALL.into_iter().find(|target| target.name() == name).ok_or_else(|| UnknownTarget(name.to_owned()))
    }
}

/// One or more targets, interleaved.
///
/// The textual form is `all`, or the names with commas between them in the order of [`Target::ALL`].
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Targets(u8);

impl Targets {
    const ALL: Self = Self(0b1_1111);

    /// Whether the targets contain the service.
    pub const fn contains(self, target: Target) -> bool {
        let bits = Self::of(target).0;
        self.0 & bits == bits
    }

    /// Draws a service at random. `below` returns a random number below its argument.
    pub(super) fn draw(self, below: impl FnOnce(usize) -> usize) -> Target {
        let shares = || Target::SHARES.into_iter().filter(|&(target, _)| self.contains(target));
        if self.0.is_power_of_two() {
            return shares().next().map_or(Target::Sdo, |(target, _)| target);
        }
        let mut drawn = below(shares().map(|(_, share)| share).sum());
        for (target, share) in shares() {
            match drawn.checked_sub(share) {
                Some(left) => drawn = left,
                None => return target,
            }
        }
        Target::Sdo
    }

    const fn of(target: Target) -> Self {
        match target {
            Target::Sdo => Self(1),
            Target::Lss => Self(1 << 1),
            Target::Nmt => Self(1 << 2),
            Target::Pdo => Self(1 << 3),
            Target::SyncEmcy => Self(1 << 4),
            Target::All => Self::ALL,
        }
    }
}

impl From<Target> for Targets {
    fn from(target: Target) -> Self {
        Self::of(target)
    }
}

impl Default for Targets {
    fn default() -> Self {
        Self::ALL
    }
}

impl fmt::Display for Targets {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if *self == Self::ALL {
            return Target::All.fmt(f);
        }
        let names: Vec<&str> =
            Target::ALL.into_iter().filter(|&target| self.contains(target)).map(Target::name).collect();
        f.write_str(&names.join(","))
    }
}

impl FromStr for Targets {
    type Err = UnknownTarget;

    fn from_str(names: &str) -> Result<Self, UnknownTarget> {
        names.split(',').try_fold(Self(0), |all, name| Ok(Self(all.0 | Self::of(name.trim().parse()?).0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn one_name_several_or_all() {
        let both: Targets = "lss,sdo".parse().unwrap();
        assert!(both.contains(Target::Sdo) && both.contains(Target::Lss) && !both.contains(Target::Nmt));
        assert_eq!(both.to_string(), "sdo,lss");
        assert_eq!("sdo, lss,sdo".parse(), Ok(both));
        assert_eq!("pdo,all".parse(), Ok(Targets::default()));
        assert_eq!("sdo,lss,nmt,pdo,sync-emcy".parse::<Targets>().unwrap().to_string(), "all");
        assert_eq!(Targets::from(Target::SyncEmcy).to_string(), "sync-emcy");
        for wrong in ["", "sdo,", "sdo;lss", "SDO"] {
            let error = wrong.parse::<Targets>().unwrap_err().to_string();
            assert!(error.contains("sync-emcy") && error.contains("sdo,lss"), "{error}");
        }
    }

    #[test]
    fn each_has_its_share_among_those_asked_for() {
        let drawn = |targets: &str, n| targets.parse::<Targets>().unwrap().draw(|_| n);
        let all: Vec<_> = (0..12).map(|n| drawn("all", n)).collect();
        let count = |target| all.iter().filter(|&&it| it == target).count();
        assert_eq!(Target::ALL.map(count), [6, 2, 1, 2, 1, 0]);
        let two: Vec<_> = (0..3).map(|n| drawn("nmt,lss", n)).collect();
        assert_eq!(two, [Target::Nmt, Target::Lss, Target::Lss]);
        // A single target needs no random number.
        assert_eq!(Targets::from(Target::Pdo).draw(|_| unreachable!()), Target::Pdo);
    }

    proptest! {
        #[test]
        fn names_read_back(bits in 1u8..32) {
            let targets = Targets(bits);
            prop_assert_eq!(targets.to_string().parse(), Ok(targets));
        }
    }
}
