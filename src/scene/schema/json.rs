//! JSON with its members in the order in which they are put, laid out to be read.

/// A JSON value.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Json {
    Boolean(bool),
    /// Finite.
    Number(f64),
    Text(String),
    List(Vec<Json>),
    Object(Members),
}

/// What an object holds, in order.
pub(super) type Members = Vec<(String, Json)>;

/// The width in characters up to which a list or an object stays on one line.
const WIDTH: usize = 100;

pub(super) fn object<N: Into<String>>(members: impl IntoIterator<Item = (N, Json)>) -> Json {
    let members = members.into_iter();
    Json::Object(
        members
            .map(|(name, member)| (name.into(), member))
            .collect(),
    )
}

pub(super) fn list(items: impl IntoIterator<Item = Json>) -> Json {
    Json::List(items.into_iter().collect())
}

impl From<f64> for Json {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl Json {
    pub(super) fn text(text: &str) -> Self {
        Self::Text(text.to_owned())
    }

    /// The value over as many lines as it needs, with a newline at the end.
    pub(super) fn pretty(&self) -> String {
        let mut text = String::new();
        self.lay_out(0, 0, &mut text);
        text.push('\n');
        text
    }

    /// Appends the value; `indent` is that of its lines, `column` where it begins.
    fn lay_out(&self, indent: usize, column: usize, text: &mut String) {
        let line = self.on_one_line();
        if column + line.chars().count() < WIDTH {
            text.push_str(&line);
            return;
        }
        let inner = indent + 2;
        let margin = " ".repeat(inner);
        let (open, close, count) = match self {
            Self::List(items) => ('[', ']', items.len()),
            Self::Object(members) => ('{', '}', members.len()),
            Self::Boolean(_) | Self::Number(_) | Self::Text(_) => {
                text.push_str(&line);
                return;
            }
        };
        text.push(open);
        text.push('\n');
        for index in 0..count {
            text.push_str(&margin);
            let mut column = inner;
            let item = match self {
                Self::Object(members) => {
                    let name = quoted(&members[index].0) + ": ";
                    column += name.chars().count();
                    text.push_str(&name);
                    &members[index].1
                }
                Self::List(items) => &items[index],
                Self::Boolean(_) | Self::Number(_) | Self::Text(_) => self,
            };
            item.lay_out(inner, column, text);
            text.push_str(if index + 1 < count { ",\n" } else { "\n" });
        }
        text.push_str(&" ".repeat(indent));
        text.push(close);
    }

    fn on_one_line(&self) -> String {
        match self {
            Self::Boolean(value) => value.to_string(),
            Self::Number(number) => {
                let plain = number.to_string();
                let short = format!("{number:e}");
                if short.len() < plain.len() {
                    short
                } else {
                    plain
                }
            }
            Self::Text(text) => quoted(text),
            Self::List(items) => {
                let items: Vec<String> = items.iter().map(Self::on_one_line).collect();
                format!("[{}]", items.join(", "))
            }
            Self::Object(members) => {
                let member = |(name, value): &(String, Self)| {
                    format!("{}: {}", quoted(name), value.on_one_line())
                };
                let members: Vec<String> = members.iter().map(member).collect();
                format!("{{ {} }}", members.join(", "))
            }
        }
    }
}

/// A JSON string.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for character in text.chars() {
        match character {
            '"' | '\\' => quoted.extend(['\\', character]),
            character if u32::from(character) < 0x20 => {
                quoted.push_str(&format!("\\u{:04x}", u32::from(character)));
            }
            character => quoted.push(character),
        }
    }
    quoted.push('"');
    quoted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_json() {
        let json = object([
            ("a \"b\"\n", Json::text("é\\")),
            (
                "n",
                list([Json::from(0.5), Json::from(1e30), Json::from(-3.0)]),
            ),
            ("t", Json::Boolean(true)),
        ]);
        assert_eq!(
            json.pretty(),
            "{ \"a \\\"b\\\"\\u000a\": \"é\\\\\", \"n\": [0.5, 1e30, -3], \"t\": true }\n"
        );
    }

    #[test]
    fn long_ones_are_parted() {
        let long = "x".repeat(60);
        let json = object([("a", list([Json::text(&long), Json::text(&long)]))]);
        assert_eq!(
            json.pretty(),
            format!("{{\n  \"a\": [\n    \"{long}\",\n    \"{long}\"\n  ]\n}}\n")
        );
    }
}
