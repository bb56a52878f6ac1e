//! A document of `rules/`, parsed.
