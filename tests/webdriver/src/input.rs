//! Mouse and keyboard actions, and work in the frames of a page.

use crate::browser::Browser;
use fantoccini::Locator;
use fantoccini::actions::{
    Actions, InputSource, KeyAction, KeyActions, MOUSE_BUTTON_LEFT, MouseActions, PointerAction,
};
use fantoccini::elements::Element;
use fantoccini::key::Key;
use serde_json::Value;
use std::time::Duration;

/// Time that the mouse takes from one place to the next.
const MOVE: Duration = Duration::from_millis(50);

impl Browser {
    /// Clicks on the first match of a selector, as a person does: it must be visible and not covered.
    #[track_caller]
    pub fn click(&self, selector: &str) {
        self.run(&format!("{}.scrollIntoView({{ block: 'center' }})", first(selector)));
        self.ask(format_args!("click {selector}"), self.find(selector).click());
    }

    /// Types into the first match of a selector.
    #[track_caller]
    pub fn fill(&self, selector: &str, text: &str) {
        self.ask(format_args!("type {text:?} into {selector}"), self.find(selector).send_keys(text));
    }

    /// Waits for an element, and drags the mouse across it, from one part of its width to another.
    #[track_caller]
    pub fn drag(&self, selector: &str, from: f64, to: f64, with_shift: bool) {
        let element = first(selector);
        self.wait(&element);
        self.run(&format!("{element}.scrollIntoView({{ block: 'center', behavior: 'instant' }})"));
        let width = self.number(&format!("return {element}.getBoundingClientRect().width"));
        // The positions count from the middle of the element: a frame within the page has another origin than the
        // window.
        let element = self.find(selector);
        let moved = |part: f64| PointerAction::MoveToElement {
            element: element.clone(),
            duration: Some(MOVE),
            x: (width * (part - 0.5)).trunc(),
            y: 0.0,
        };
        // Keyboard and mouse act in parallel steps: the key goes down before the button does, and up after it.
        let pause = Duration::ZERO;
        let mouse = MouseActions::new("mouse".to_owned())
            .then(moved(from))
            .pause(pause)
            .then(PointerAction::Down { button: MOUSE_BUTTON_LEFT })
            .then(moved((from + to) / 2.0))
            .then(moved(to))
            .then(PointerAction::Up { button: MOUSE_BUTTON_LEFT })
            .pause(pause);
        let value = char::from(Key::Shift);
        let mut keys = KeyActions::new("keyboard".to_owned()).pause(pause);
        keys = if with_shift { keys.then(KeyAction::Down { value }) } else { keys.pause(pause) };
        keys = keys.pause(pause).pause(pause).pause(pause).pause(pause);
        keys = if with_shift { keys.then(KeyAction::Up { value }) } else { keys.pause(pause) };
        let actions = Actions::from(keys).and(mouse);
        self.ask(format_args!("drag {selector} from {from} to {to}"), self.client.perform_actions(actions));
    }

    /// Presses a key in the first match of a selector.
    #[track_caller]
    pub fn press(&self, selector: &str, key: &str) {
        let [value] = key.chars().collect::<Vec<_>>()[..] else { panic!("expected one key, found {key:?}") };
        self.run(&format!("{}.focus({{ preventScroll: true }})", first(selector)));
        let keys = KeyActions::new("keyboard".to_owned());
        let keys = keys.then(KeyAction::Down { value }).then(KeyAction::Up { value });
        self.ask(format_args!("press {key:?} in {selector}"), self.client.perform_actions(keys));
    }

    /// Acts in the frame that a selector matches first.
    #[track_caller]
    pub fn within(&self, selector: &str, act: impl FnOnce(&Self)) {
        self.ask(format_args!("enter the frame {selector}"), self.find(selector).enter_frame());
        act(self);
        self.ask(format_args!("leave the frame {selector}"), self.client.enter_parent_frame());
    }

    #[track_caller]
    fn find(&self, selector: &str) -> Element {
        self.ask(format_args!("find {selector}"), self.client.find(Locator::Css(selector)))
    }
}

/// A JavaScript expression for the first match of a selector.
fn first(selector: &str) -> String {
    format!("document.querySelector({})", Value::from(selector))
}
