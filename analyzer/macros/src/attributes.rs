//! The keys of the attribute.

use proc_macro2::Span;
use syn::parse::{Parse, ParseStream};
use syn::punctuated::Punctuated;
use syn::{Error, Ident, LitStr, Result, Token, bracketed};

/// What stands between the parentheses of `#[rule(…)]`.
pub struct Attributes {
    pub id: LitStr,
    pub severity: Ident,
    pub services: Services,
    pub also: Vec<Ident>,
    pub of: Of,
}

/// The services whose frames a rule is shown.
pub enum Services {
    All,
    These(Vec<Ident>),
}

/// What a rule is about.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Of {
    /// A bus.
    Bus,
    /// A whole capture.
    Capture,
    /// Other code reports what it finds.
    Nothing,
}

/// The same while it is read.
#[derive(Default)]
struct Keys {
    id: Option<LitStr>,
    severity: Option<Ident>,
    services: Option<Services>,
    also: Option<Vec<Ident>>,
    of: Option<Ident>,
}

impl Parse for Attributes {
    fn parse(input: ParseStream) -> Result<Self> {
        let whole = input.span();
        let mut keys = Keys::default();
        while !input.is_empty() {
            keys.read_one(input)?;
            if !input.is_empty() {
                input.parse::<Token![,]>()?;
            }
        }
        keys.complete(whole)
    }
}

impl Keys {
    fn read_one(&mut self, input: ParseStream) -> Result<()> {
        let key: Ident = input.parse()?;
        input.parse::<Token![=]>()?;
        let twice = match key.to_string().as_str() {
            "id" => self.id.replace(input.parse()?).is_some(),
            "severity" => self.severity.replace(input.parse()?).is_some(),
            "services" => self.services.replace(services(input)?).is_some(),
            "also" => self.also.replace(one_or_several(input)?).is_some(),
            "of" => self.of.replace(input.parse()?).is_some(),
            _ => {
                let known = "id, severity, services, also and of";
                return Err(Error::new(key.span(), format!("no key of a rule is called `{key}`: there are {known}")));
            }
        };
        if twice { Err(Error::new(key.span(), format!("`{key}` is given twice"))) } else { Ok(()) }
    }

    fn complete(self, whole: Span) -> Result<Attributes> {
        let id = required(self.id, "id = \"nodes/…\"", whole)?;
        check_id(&id)?;
        let of = match self.of.as_ref().map(ToString::to_string).as_deref() {
            None => Of::Bus,
            Some("capture") => Of::Capture,
            Some("nothing") => Of::Nothing,
            Some(other) => {
                return Err(Error::new(whole, format!("a rule is `of = capture` or `of = nothing`, not `{other}`")));
            }
        };
        let services = self.services.unwrap_or(Services::These(Vec::new()));
        let sees_nothing = matches!(&services, Services::These(none) if none.is_empty()) && self.also.is_none();
        if sees_nothing == (of == Of::Bus) {
            let advice = "a rule of a bus is shown frames, by `services` or `also`; no other rule is";
            return Err(Error::new(whole, advice));
        }
        let severity = required(self.severity, "severity = Error|Warning|Info", whole)?;
        Ok(Attributes { id, severity, services, also: self.also.unwrap_or_default(), of })
    }
}

fn required<T>(value: Option<T>, key: &str, whole: Span) -> Result<T> {
    value.ok_or_else(|| Error::new(whole, format!("the rule lacks `{key}`")))
}

fn services(input: ParseStream) -> Result<Services> {
    if input.peek(Ident) {
        let all: Ident = input.parse()?;
        if all == "all" {
            return Ok(Services::All);
        }
        return Err(Error::new(all.span(), "services are `[Sdo, Nmt]`, or `all`"));
    }
    Ok(Services::These(several(input)?))
}

/// `KnownTpdos`, or `[KnownTpdos, EndedTransfers]`.
fn one_or_several(input: ParseStream) -> Result<Vec<Ident>> {
    if input.peek(Ident) { Ok(vec![input.parse()?]) } else { several(input) }
}

fn several(input: ParseStream) -> Result<Vec<Ident>> {
    let content;
    bracketed!(content in input);
    let list = Punctuated::<Ident, Token![,]>::parse_terminated(&content)?;
    Ok(list.into_iter().collect())
}

/// Ids are typed on command lines: a family and a name of lower-case words.
fn check_id(id: &LitStr) -> Result<()> {
    let text = id.value();
    let good = |part: &str| {
        !part.is_empty() && part.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-')
    };
    match text.split_once('/') {
        Some((family, name)) if good(family) && good(name) => Ok(()),
        _ => Err(Error::new(id.span(), "an id is a family and lower-case words, such as \"nodes/heartbeat-missing\"")),
    }
}
