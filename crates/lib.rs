//! Exact event-driven simulation of two-dimensional gases of rigid molecules.
