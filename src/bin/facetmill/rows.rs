//! Rows of the tables that a person sees.

/// Name, value and meaning of a figure.
pub type Row = [String; 3];

/// A row of a table.
pub fn row(name: &str, value: impl Into<String>, meaning: impl Into<String>) -> Row {
    [name.to_owned(), value.into(), meaning.into()]
}

/// A line without a figure of its own.
pub fn told(name: &str, what: String) -> Row {
    row(name, "", what)
}

/// A share in percent with two decimals. What rounds to nothing is nothing, without a sign.
pub fn percent(share: f64) -> String {
    format!("{:.2} %", (1e4 * share).round() / 100.0 + 0.0)
}
