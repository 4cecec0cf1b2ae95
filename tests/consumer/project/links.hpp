#pragma once

/// A bad graph is refused with its line, a good one read.
bool reads_graphs();

/// A bad radar configuration is refused with its line.
bool reads_chirps();

/// There is nothing to match without points.
bool matches_scans();

/// A Gauss-Markov state decays as its process says.
bool filters();
bool own_states();

/// A level is tracked by a particle filter put together from the library's steps.
bool own_particles();

/// A unit at rest stays where it is, and its position becomes uncertain as by hand.
bool predicts_motion();

/// A lift is tracked by a state, edges and a robust kernel of its own.
bool own_edges();

/// A cart is found by a likelihood, a map and a model of odometry of its own.
bool own_localiser();
