//! What is wanted, beside what was measured.
