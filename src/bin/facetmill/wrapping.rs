//! Text for a terminal of 80 columns.

/// Columns that are used.
pub const WIDTH: usize = 80;

/// `text` in lines of [`WIDTH`] at the most, broken between words; `first` stands before the first line, and as many blanks
/// before the others. A word that is longer stands alone. Ends with a line end.
pub fn wrapped(first: &str, text: &str) -> String {
    let indent = first.chars().count();
    let mut lines = String::new();
    let mut line = first.to_owned();
    let mut empty = true;
    for word in text.split(' ').filter(|word| !word.is_empty()) {
        if !empty && line.chars().count() + 1 + word.chars().count() > WIDTH {
            lines += line.trim_end();
            lines.push('\n');
            line = " ".repeat(indent);
            empty = true;
        }
        if !empty {
            line.push(' ');
        }
        line += word;
        empty = false;
    }
    lines += line.trim_end();
    lines.push('\n');
    lines
}

/// The first `most` letters of `text`, the last of them an ellipsis if there are more.
pub fn cut(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    text.chars().take(most.saturating_sub(1)).chain(['…']).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_broken_between_words_and_hang_below_their_first() {
        let text = "light ".repeat(40);
        let told = wrapped("  Note: ", &text);
        assert!(told.lines().count() > 2 && told.lines().all(|line| line.chars().count() <= WIDTH), "{told}");
        assert!(
            told.starts_with("  Note: light light")
                && told.lines().skip(1).all(|line| line.starts_with("        light"))
        );
        assert_eq!(told.split_whitespace().count(), 41);
        assert_eq!(wrapped("  ", "short"), "  short\n");
        let path = "x".repeat(100);
        assert_eq!(wrapped("a ", &format!("see {path} now")), format!("a see\n  {path}\n  now\n"));
        assert_eq!(wrapped("name", ""), "name\n");
    }

    #[test]
    fn what_is_cut_says_so() {
        assert_eq!((cut("höhe", 4), cut("höhen", 4)), ("höhe".into(), "höh…".into()));
    }
}
