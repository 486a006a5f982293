//! The keys of `#[rule]`.

use crate::keys::{self, Keys, is_id_part, list};
use proc_macro2::Span;
use syn::parse::{Parse, ParseStream};
use syn::{Error, Expr, Ident, LitStr, Result};

/// The values of the keys between the parentheses of `#[rule(…)]`.
pub struct Attributes {
    pub id: LitStr,
    pub severity: Ident,
    pub rank: Ident,
    pub leads_to: Option<Expr>,
    pub follows: Option<Expr>,
    pub services: Services,
    pub also: Vec<Ident>,
    pub of: Of,
}

/// The services whose frames a rule gets.
pub enum Services {
    All,
    These(Vec<Ident>),
}

/// The subject of a rule.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Of {
    /// One bus.
    Bus,
    /// A whole capture.
    Capture,
    /// No subject of its own: other code reports the findings.
    Nothing,
}

/// The keys of `#[rule]` while they are read; `None` for a key that was not given yet.
#[derive(Default)]
struct RuleKeys {
    id: Option<LitStr>,
    severity: Option<Ident>,
    rank: Option<Ident>,
    leads_to: Option<Expr>,
    follows: Option<Expr>,
    services: Option<Services>,
    also: Option<Vec<Ident>>,
    of: Option<Ident>,
}

impl Parse for Attributes {
    fn parse(input: ParseStream) -> Result<Self> {
        let whole = input.span();
        keys::read::<RuleKeys>(input)?.complete(whole)
    }
}

impl Keys for RuleKeys {
    const ITEM: &str = "rule";
    const KNOWN: &str = "id, severity, rank, services, also, of, leads_to and follows";

    fn read(&mut self, key: &str, value: ParseStream) -> Result<Option<bool>> {
        Ok(Some(match key {
            "id" => self.id.replace(value.parse()?).is_some(),
            "severity" => self.severity.replace(value.parse()?).is_some(),
            "rank" => self.rank.replace(value.parse()?).is_some(),
            "leads_to" => self.leads_to.replace(value.parse()?).is_some(),
            "follows" => self.follows.replace(value.parse()?).is_some(),
            "services" => self.services.replace(services(value)?).is_some(),
            "also" => self.also.replace(one_or_several(value)?).is_some(),
            "of" => self.of.replace(value.parse()?).is_some(),
            _ => return Ok(None),
        }))
    }
}

impl RuleKeys {
    fn complete(self, whole: Span) -> Result<Attributes> {
        let id = Self::required(self.id, "id = \"nodes/…\"", whole)?;
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
        let severity = Self::required(self.severity, "severity = Error|Warning|Info", whole)?;
        let rank = Self::required(self.rank, "rank = Loss|Restart|Participants|DeviceError|…|Detail", whole)?;
        let also = self.also.unwrap_or_default();
        let (leads_to, follows) = (self.leads_to, self.follows);
        Ok(Attributes { id, severity, rank, leads_to, follows, services, also, of })
    }
}

fn services(input: ParseStream) -> Result<Services> {
    if input.peek(Ident) {
        let all: Ident = input.parse()?;
        if all == "all" {
            return Ok(Services::All);
        }
        return Err(Error::new(all.span(), "services are `[Sdo, Nmt]`, or `all`"));
    }
    Ok(Services::These(list(input, Ident::parse)?))
}

/// Reads one name or several: `KnownTpdos`, or `[KnownTpdos, EndedTransfers]`.
fn one_or_several(input: ParseStream) -> Result<Vec<Ident>> {
    if input.peek(Ident) { Ok(vec![input.parse()?]) } else { list(input, Ident::parse) }
}

/// Checks that an id is a family and a name, each of lower-case words.
fn check_id(id: &LitStr) -> Result<()> {
    let text = id.value();
    match text.split_once('/') {
        Some((family, name)) if is_id_part(family) && is_id_part(name) => Ok(()),
        _ => Err(Error::new(id.span(), "an id is a family and lower-case words, such as \"nodes/heartbeat-missing\"")),
    }
}
