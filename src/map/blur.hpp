#pragma once

// Gaussian blur of a row-major image.

#include <vector>

namespace wayfare {

/// In place; `sigma_cells` above 0. Pixels outside the image have the value `outside`.
void blur(std::vector<float>& image, int width, int height, double sigma_cells, float outside);

}  // namespace wayfare
