//! The table of allowed answers in words.

use canvass_suite::situation::Situation;

/// The answers that pass, the best first: `0609 0011h`, `0504 0000h or no answer`.
pub fn allowed(situation: Situation) -> String {
    let answers = situation.answers();
    let mut words = codes(answers.aborts);
    words.extend(answers.any_abort.then(|| "any abort".to_owned()));
    words.extend(answers.silence.then(|| "no answer".to_owned()));
    words.extend(answers.confirmation.then(|| "confirmation".to_owned()));
    words.join(" or ")
}

/// The answers that only CiA's test tool accepts. Empty if there are none.
pub fn tolerated(situation: Situation) -> String {
    codes(situation.answers().tolerated).join(" or ")
}

fn codes(codes: &[canvass_analyzer::wire::sdo::AbortCode]) -> Vec<String> {
    codes.iter().map(|code| format!("{:04X} {:04X}h", code.0 >> 16, code.0 & 0xFFFF)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_answer_comes_first() {
        assert_eq!(allowed(Situation::RepeatedToggle), "0503 0000h or no answer");
        assert_eq!(allowed(Situation::ValidCobIdChanged), "any abort");
        assert_eq!(tolerated(Situation::ReadOnly), "0601 0000h or 0800 0000h");
        assert_eq!(tolerated(Situation::StoreUnsupported), "");
    }
}
