//! The rules: one number, one document, one predicate each.
