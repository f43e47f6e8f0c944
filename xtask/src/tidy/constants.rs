//! What the constants in a line of code are worth: literals, and expressions of nothing but literals.
//!
//! It knows as much of Rust's expressions as small numbers get written with: products, shifts, powers, casts, bits.

/// A number, and whether it is a float.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Constant {
    pub(super) value: f64,
    pub(super) is_float: bool,
}

impl Constant {
    fn float(value: f64) -> Self {
        Self { value, is_float: true }
    }
}

/// What the code calls the types and the crate whose functions are known.
const FLOATS: [&str; 3] = ["f32", "f64", "libm"];

/// The constants of a line that pass a test, each with its text; of those that begin at one place the longest, or else the
/// first literal. What is divided by a constant counts as one.
pub(super) fn constants_where(line: &str, passes: impl Fn(Constant) -> bool) -> Vec<&str> {
    let tokens = tokens(line);
    let (mut found, mut start) = (Vec::new(), 0);
    while start < tokens.len() {
        let candidates = [expression(&tokens, start), literal(tokens[start].1).map(|number| (number, start + 1))];
        let passing = candidates.into_iter().flatten().find(|(constant, _)| passes(*constant));
        start = passing.map_or(start + 1, |(_, end)| {
            let (last, text) = tokens[end - 1];
            found.push(&line[tokens[start].0..last + text.len()]);
            end
        });
    }
    found
}

/// The longest product that begins at a token, or the inverse of what something else is divided by there; and where it ends.
fn expression(tokens: &[(usize, &str)], start: usize) -> Option<(Constant, usize)> {
    let mut reader = Reader { tokens, next: start };
    let is_new = start.checked_sub(1).is_none_or(|before| literal(tokens[before].1).is_none());
    let constant = match tokens[start].1 {
        "/" if is_new => {
            reader.next += 1;
            let divisor = reader.factor()?;
            Constant { value: 1.0 / divisor.value, ..divisor }
        }
        "-" => return None,
        _ => reader.product()?,
    };
    Some((constant, reader.next))
}

/// Words, numbers with their suffixes, fields with their points, and signs; each with its place.
fn tokens(line: &str) -> Vec<(usize, &str)> {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let (mut found, mut at) = (Vec::new(), 0);
    while let Some(first) = line[at..].chars().next() {
        let rest = &line[at..];
        let number = if first.is_ascii_digit() { number_length(rest) } else { 0 };
        let is_field = first == '.' && rest[1..].starts_with(|c: char| c.is_ascii_digit());
        let begun = if is_field { 1 } else { number };
        let length = match begun + rest[begun..].find(|c| !is_word(c)).unwrap_or(rest.len() - begun) {
            0 if ["<<", "::", ".."].iter().any(|sign| rest.starts_with(sign)) => 2,
            0 => first.len_utf8(),
            word => word,
        };
        if !first.is_whitespace() {
            found.push((at, &rest[..length]));
        }
        at += length;
    }
    found
}

/// The decimal number that a token is.
fn literal(token: &str) -> Option<Constant> {
    let (number, suffix) = token.split_at(number_length(token));
    let suffix = suffix.trim_start_matches('_');
    let is_integer = suffix.starts_with(['u', 'i']);
    if !token.starts_with(|c: char| c.is_ascii_digit())
        || !(suffix.is_empty() || is_integer || FLOATS.contains(&suffix))
    {
        return None;
    }
    let is_float = FLOATS.contains(&suffix) || number.contains(['.', 'e', 'E']);
    Some(Constant { value: number.replace('_', "").parse().ok()?, is_float })
}

/// How long the decimal number at the beginning of a text is.
fn number_length(text: &str) -> usize {
    let digits = |from: usize| {
        let rest = text.get(from..).unwrap_or_default();
        rest.find(|c: char| !(c.is_ascii_digit() || c == '_')).unwrap_or(rest.len())
    };
    let mut length = digits(0);
    if text[length..].starts_with('.') && digits(length + 1) > 0 {
        length += 1 + digits(length + 1);
    }
    if text[length..].starts_with(['e', 'E']) {
        let sign = usize::from(text[length + 1..].starts_with(['-', '+']));
        let exponent = digits(length + 1 + sign);
        length += if exponent > 0 { 1 + sign + exponent } else { 0 };
    }
    length
}

/// Reads constant expressions; each function takes the tokens of what it returns.
struct Reader<'a> {
    tokens: &'a [(usize, &'a str)],
    next: usize,
}

impl<'a> Reader<'a> {
    fn peek(&self) -> Option<&'a str> {
        self.tokens.get(self.next).map(|(_, text)| *text)
    }

    fn take(&mut self) -> Option<&'a str> {
        self.next += 1;
        self.tokens.get(self.next - 1).map(|(_, text)| *text)
    }

    fn takes(&mut self, text: &str) -> bool {
        let is_there = self.peek() == Some(text);
        self.next += usize::from(is_there);
        is_there
    }

    /// Operands, joined from the left; where an operator has no constant after it, what is before it is all.
    fn joined(
        &mut self,
        operators: &[&str],
        operand: fn(&mut Self) -> Option<Constant>,
        join: fn(&str, f64, f64) -> f64,
    ) -> Option<Constant> {
        let mut left = operand(self)?;
        while let Some(operator) = self.peek().filter(|text| operators.contains(text)) {
            let end = self.next;
            self.next += 1;
            let Some(right) = operand(self) else {
                self.next = end;
                break;
            };
            left =
                Constant { value: join(operator, left.value, right.value), is_float: left.is_float || right.is_float };
        }
        Some(left)
    }

    fn product(&mut self) -> Option<Constant> {
        self.joined(&["*", "/"], Self::factor, |operator, a, b| if operator == "*" { a * b } else { a / b })
    }

    fn sum(&mut self) -> Option<Constant> {
        self.joined(&["+", "-"], Self::product, |operator, a, b| if operator == "+" { a + b } else { a - b })
    }

    fn shift(&mut self) -> Option<Constant> {
        self.joined(&["<<"], Self::sum, |_, a, b| a * 2f64.powi(b as i32))
    }

    /// A number with its sign, methods and casts.
    fn factor(&mut self) -> Option<Constant> {
        if self.takes("-") {
            let positive = self.factor()?;
            return Some(Constant { value: -positive.value, ..positive });
        }
        let mut constant = self.primary()?;
        loop {
            if self.takes("as") {
                constant.is_float = FLOATS.contains(&self.take()?);
            } else if self.takes(".") {
                let method = self.take()?;
                let arguments = self.arguments()?;
                constant = Constant::float(call("f64", method, &[&[constant.value], &*arguments].concat())?);
            } else {
                return Some(constant);
            }
        }
    }

    fn primary(&mut self) -> Option<Constant> {
        let token = self.take()?;
        if token == "(" {
            let inner = self.shift()?;
            return self.takes(")").then_some(inner);
        }
        if FLOATS.contains(&token) && self.takes("::") {
            let function = self.take()?;
            let arguments = self.arguments()?;
            return call(token, function, &arguments).map(Constant::float);
        }
        literal(token)
    }

    fn arguments(&mut self) -> Option<Vec<f64>> {
        let mut arguments = Vec::new();
        let mut is_open = self.takes("(") && !self.takes(")");
        while is_open {
            arguments.push(self.shift()?.value);
            is_open = self.takes(",");
            if !is_open && !self.takes(")") {
                return None;
            }
        }
        Some(arguments)
    }
}

/// The value of a function that numbers get written with.
fn call(float: &str, function: &str, arguments: &[f64]) -> Option<f64> {
    Some(match (function, arguments) {
        ("powi" | "powf" | "pow", [base, exponent]) => base.powi(*exponent as i32),
        ("ldexp", [number, exponent]) => number * 2f64.powi(*exponent as i32),
        ("exp2", [exponent]) => 2f64.powi(*exponent as i32),
        ("recip", [number]) => 1.0 / number,
        ("sqrt", [square]) => square.sqrt(),
        ("from", [number]) => *number,
        ("from_bits", [bits]) if float == "f32" => f64::from(f32::from_bits(*bits as u32)),
        ("from_bits", [bits]) => f64::from_bits(*bits as u64),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(line: &str) -> Option<Constant> {
        expression(&tokens(line), 0).map(|(constant, _)| constant)
    }

    #[test]
    fn expressions_are_worth_what_rust_makes_of_them() {
        for (line, worth) in [
            ("1.0 / (1u64 << 40) as f64", 1.0 / (1u64 << 40) as f64),
            ("8.0 / 2.0 / 4.0 * 3.0", 8.0 / 2.0 / 4.0 * 3.0),
            ("(1.0 + 2.0 * 3.0 - 4.0)", 1.0 + 2.0 * 3.0 - 4.0),
            ("f64::from(1u32 << 4 + 2)", f64::from(1u32 << (4 + 2))),
            ("f64::powi(0.5, 20)", f64::powi(0.5, 20)),
            ("0.5f64.powi(20).sqrt()", 0.5f64.powi(20).sqrt()),
            ("(-3.0 as f64).recip()", (-3.0_f64).recip()),
            ("f64::from_bits((1023 - 40) << 52)", f64::from_bits((1023 - 40) << 52)),
            ("f32::from_bits((127 - 20) << 23)", f64::from(f32::from_bits((127 - 20) << 23))),
            ("x / 4096.0", f64::NAN),
            ("/ 4096.0", 1.0 / 4096.0),
        ] {
            match value(line) {
                Some(constant) => assert_eq!(constant, Constant::float(worth), "{line}"),
                None => assert!(worth.is_nan(), "{line}"),
            }
        }
    }

    #[test]
    fn what_is_no_constant_ends_an_expression() {
        assert_eq!(value("8.0 * f64::EPSILON"), Some(Constant::float(8.0)));
        assert_eq!(value("1 / 4096"), Some(Constant { value: 1.0 / 4096.0, is_float: false }));
        for line in ["2.0.min(x)", "2f64.powi(-n)", "(1.0 + x)", "0x1e", "f64::MAX", ""] {
            assert!(tokens(line).is_empty() || value(line).is_none(), "{line}");
        }
    }
}
