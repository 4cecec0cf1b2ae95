#include "map/blur.hpp"

#include <cmath>
#include <cstddef>

namespace wayfare {
namespace {

std::vector<float> gaussian(double sigma_cells) {
  const int radius = static_cast<int>(std::ceil(3 * sigma_cells));
  std::vector<float> weights;
  float sum = 0;
  for (int i = -radius; i <= radius; ++i) {
    weights.push_back(static_cast<float>(std::exp(-0.5 * i * i / (sigma_cells * sigma_cells))));
    sum += weights.back();
  }
  for (float& w : weights) w /= sum;
  return weights;
}

/// Convolves a line of `n` values, `step` apart; values outside it are `outside`.
void blur_line(float* line, int n, std::ptrdiff_t step, const std::vector<float>& weights,
               float outside, std::vector<float>& copy) {
  const int radius = static_cast<int>(weights.size() / 2);
  copy.assign(static_cast<std::size_t>(n + 2 * radius), outside);
  for (int i = 0; i < n; ++i) copy[static_cast<std::size_t>(i + radius)] = line[i * step];
  for (int i = 0; i < n; ++i) {
    float sum = 0;
    for (std::size_t k = 0; k < weights.size(); ++k)
      sum += weights[k] * copy[static_cast<std::size_t>(i) + k];
    line[i * step] = sum;
  }
}

}  // namespace

void blur(std::vector<float>& p, int width, int height, double sigma_cells, float outside) {
  const std::vector<float> weights = gaussian(sigma_cells);
  std::vector<float> copy;
  for (int y = 0; y < height; ++y)
    blur_line(p.data() + std::ptrdiff_t{y} * width, width, 1, weights, outside, copy);
  for (int x = 0; x < width; ++x) blur_line(p.data() + x, height, width, weights, outside, copy);
}

}  // namespace wayfare
