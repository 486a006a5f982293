//! Topics and their channels: the topic alone determines the bus.

/// The suffix of the topic of a channel's CAN FD frames.
const FD: &str = "/fd";

/// The channel of a topic: `can0` for `/can0` and `/can0/fd`.
pub(crate) fn channel(topic: &str) -> &str {
    let name = topic.trim_start_matches('/');
    match name.strip_suffix(FD) {
        Some(bus) if !bus.is_empty() => bus,
        _ => name,
    }
}

/// The topic of a channel's frames.
pub(crate) fn topic(channel: &str, fd: bool) -> String {
    format!("/{channel}{}", if fd { FD } else { "" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back() {
        assert_eq!((channel("/can0"), channel("/can0/fd"), channel("from_can_bus")), ("can0", "can0", "from_can_bus"));
        assert_eq!(channel("/fd"), "fd");
        assert_eq!((topic("can0", false), topic("can0", true)), ("/can0".to_owned(), "/can0/fd".to_owned()));
    }
}
