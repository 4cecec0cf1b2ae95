#pragma once

/// A bad graph is refused with its line, a good one read.
bool reads_graphs();

/// A bad radar configuration is refused with its line.
bool reads_chirps();

/// Lines of text are a protocol of its own.
bool own_framing();

/// There is nothing to match without points.
bool matches_scans();

/// A Gauss-Markov state decays as its process says.
bool filters();
bool own_states();

/// A gauge that reads too high is rejected by a gate of its own.
bool own_gates();

/// Steps have the length of a model of its own, stances a statistic of its own.
bool own_steps();

/// A level is tracked by a particle filter put together from the library's steps.
bool own_particles();

/// A unit at rest stays where it is, and its position becomes uncertain as by hand.
bool predicts_motion();

/// A lift is tracked by a state, edges and a robust kernel of its own.
bool own_edges();

/// A staircase is levelled by linear solvers of its own, which find what is not determined.
bool own_solver();

/// A room is mapped by graph, submap and Hector SLAM with a matcher of its own.
bool own_matcher();

/// A cart is found by a likelihood, a map and a model of odometry of its own, also in a recording.
bool own_localiser();
