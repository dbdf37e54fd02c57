//! ductloop
