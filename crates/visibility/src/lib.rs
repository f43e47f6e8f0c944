//! Which surface a camera sees
