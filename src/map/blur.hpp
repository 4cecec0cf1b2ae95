#pragma once

// Gaussian blur of a row-major picture, for the views of maps.

#include <vector>

namespace wayfare {

/// In place; `sigma_cells` above 0. What lies outside the picture counts as `outside`.
void blur(std::vector<float>& picture, int width, int height, double sigma_cells, float outside);

}  // namespace wayfare
