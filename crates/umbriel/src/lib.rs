//! Shadows in object space with a known error
