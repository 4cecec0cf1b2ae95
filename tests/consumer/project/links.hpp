#pragma once

/// A bad graph is refused with its line, a good one read.
bool reads_graphs();

/// There is nothing to match without points.
bool matches_scans();
