//! Finds the features of a collection without reading them, so that each can be read by itself, with its place.

use std::ops::Range;

/// Where things stand in the text of a feature collection.
#[derive(Debug, PartialEq, Eq)]
pub struct FeatureSpans {
    /// The list of features, without its brackets.
    pub list: Range<usize>,
    /// Each feature.
    pub features: Vec<Range<usize>>,
}

/// The layout of a JSON object with a member `features`. `None` if the text is no object or has no such list; faults
/// inside the features are not looked for.
pub fn scan(text: &str) -> Option<FeatureSpans> {
    let mut scanner = Scanner { bytes: text.as_bytes(), at: 0 };
    scanner.take(b'{')?;
    let mut layout = None;
    loop {
        let key = scanner.string()?;
        scanner.take(b':')?;
        match key {
            b"features" if scanner.peek()? == b'[' => layout = Some(scanner.list()?),
            _ => scanner.pass()?,
        }
        if scanner.peek()? != b',' {
            break;
        }
        scanner.at += 1;
    }
    scanner.take(b'}')?;
    layout
}

struct Scanner<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Scanner<'a> {
    /// The next byte that is no white space.
    fn peek(&mut self) -> Option<u8> {
        while self.bytes.get(self.at)?.is_ascii_whitespace() {
            self.at += 1;
        }
        self.bytes.get(self.at).copied()
    }

    fn take(&mut self, wanted: u8) -> Option<()> {
        let found = self.peek()? == wanted;
        self.at += 1;
        found.then_some(())
    }

    /// The inside of a string.
    fn string(&mut self) -> Option<&'a [u8]> {
        self.take(b'"')?;
        let start = self.at;
        loop {
            match self.bytes.get(self.at)? {
                b'"' => break,
                b'\\' => self.at += 2,
                _ => self.at += 1,
            }
        }
        self.at += 1;
        Some(&self.bytes[start..self.at - 1])
    }

    fn pass(&mut self) -> Option<()> {
        self.value().map(|_| ())
    }

    fn value(&mut self) -> Option<Range<usize>> {
        let first = self.peek()?;
        let start = self.at;
        match first {
            b'"' => drop(self.string()?),
            b'{' | b'[' => self.nested()?,
            _ => {
                let plain = |b: &u8| !matches!(b, b',' | b']' | b'}') && !b.is_ascii_whitespace();
                self.at += self.bytes[start..].iter().take_while(|b| plain(b)).count();
            }
        }
        (self.at > start).then_some(start..self.at)
    }

    /// Passes an object or a list, however deep.
    fn nested(&mut self) -> Option<()> {
        let mut depth = 0_usize;
        loop {
            match self.bytes.get(self.at)? {
                b'"' => {
                    self.string()?;
                    continue;
                }
                b'{' | b'[' => depth += 1,
                b'}' | b']' => depth -= 1,
                _ => {}
            }
            self.at += 1;
            if depth == 0 {
                return Some(());
            }
        }
    }

    fn list(&mut self) -> Option<FeatureSpans> {
        self.take(b'[')?;
        let start = self.at;
        let mut features = Vec::new();
        if self.peek()? != b']' {
            loop {
                features.push(self.value()?);
                match self.peek()? {
                    b',' => self.at += 1,
                    _ => break,
                }
            }
        }
        let end = self.at;
        self.take(b']')?;
        Some(FeatureSpans { list: start..end, features })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn features(text: &str) -> Option<Vec<&str>> {
        let layout = scan(text)?;
        Some(layout.features.into_iter().map(|range| &text[range]).collect())
    }

    #[test]
    fn features_are_found_between_everything_else() {
        let text = r#" {"a": "]},{", "features" : [ {"x": [1, {"y": "\"]"}]} , 7,null ], "features2": [1], "b": {}}"#;
        assert_eq!(features(text), Some(vec![r#"{"x": [1, {"y": "\"]"}]}"#, "7", "null"]));
        assert_eq!(features(r#"{"features":[]}"#), Some(vec![]));
    }

    #[test]
    fn what_is_no_collection_has_none() {
        for text in
            ["", "[]", "{}", "{\"features\": 3}", "{\"features\": [1, 2", "{\"features\": [1,,2]}", "<osm>", "{\"a"]
        {
            assert_eq!(features(text), None, "{text}");
        }
    }
}
