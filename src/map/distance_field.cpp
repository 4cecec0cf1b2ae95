#include <wayfare/map/distance_field.hpp>

#include <algorithm>
#include <array>
#include <string>

#include "map/kernels/kernels.hpp"

namespace wayfare {
namespace {

using kernels::kFarCells;
static_assert(DistanceField::kFar == kernels::kFarSquared);

/// Cells to the nearest occupied one of the same column; false if no cell is occupied.
bool column_distances(std::span<const std::uint8_t> occupied, int width, int height,
                      std::vector<std::uint16_t>& column) {
  const auto& k = kernels::best_kernels();
  const auto w = static_cast<std::size_t>(width);
  column.resize(w * static_cast<std::size_t>(height));
  const std::vector<std::uint16_t> nothing(w, kFarCells);
  const std::uint16_t* before = nothing.data();
  for (int y = 0; y < height; ++y) {
    std::uint16_t* here = column.data() + static_cast<std::size_t>(y) * w;
    k.column_step(occupied.data() + static_cast<std::size_t>(y) * w, before, here, width);
    before = here;
  }
  const bool any = std::any_of(before, before + w, [](std::uint16_t d) { return d < kFarCells; });
  for (int y = height - 2; any && y >= 0; --y) {
    std::uint16_t* here = column.data() + static_cast<std::size_t>(y) * w;
    k.column_back(here + w, here, width);
  }
  return any;
}

Result<void> check_size(std::int64_t width, std::int64_t height) {
  constexpr int kMaxSide = DistanceField::kMaxSide;
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide ||
      width * height > DistanceField::kMaxCells)
    return Error{ErrorCode::invalid, "DistanceField: " + std::to_string(width) + " x " +
                                         std::to_string(height) + " cells are too many"};
  return {};
}

bool in_range(const Cell& c) {
  return c.x >= -kMaxCell && c.y >= -kMaxCell && c.x <= kMaxCell && c.y <= kMaxCell;
}

std::int64_t floor_divide(std::int64_t a, std::int64_t b) {
  return a / b - (a % b != 0 && (a < 0) != (b < 0) ? 1 : 0);
}

/// Row minima by the lower envelope of parabolas (Felzenszwalb and Huttenlocher 2012), in integers:
/// for rows whose obstacles are far.
class LowerEnvelope {
 public:
  void operator()(const std::uint16_t* column, int n, std::int32_t* out) {
    vertices_.clear();
    from_.clear();
    for (int q = 0; q < n; ++q) {
      if (column[q] >= kFarCells) continue;
      std::int64_t begin = 0;
      while (!vertices_.empty()) {
        // The first column at which q is strictly nearer than the envelope's last vertex.
        const std::int64_t p = vertices_.back();
        begin = floor_divide(key(column, q) - key(column, p), 2 * (q - p)) + 1;
        if (begin > from_.back()) break;
        vertices_.pop_back();
        from_.pop_back();
        begin = 0;
      }
      if (begin >= n) continue;
      vertices_.push_back(q);
      from_.push_back(std::max<std::int64_t>(begin, 0));
    }
    std::size_t i = 0;
    for (int x = 0; x < n; ++x) {
      while (i + 1 < vertices_.size() && from_[i + 1] <= x) ++i;
      const std::int64_t across = x - vertices_[i], along = column[vertices_[i]];
      out[x] = static_cast<std::int32_t>(across * across + along * along);
    }
  }

 private:
  static std::int64_t key(const std::uint16_t* column, std::int64_t q) {
    return std::int64_t{column[q]} * column[q] + q * q;
  }
  std::vector<std::int64_t> vertices_, from_;
};

}  // namespace

Result<DistanceField> DistanceField::of_mask(std::span<const std::uint8_t> occupied, int width,
                                             int height, double resolution_m, const Cell& origin) {
  if (!(resolution_m > 0) || !std::isfinite(resolution_m))
    return Error{ErrorCode::invalid, "DistanceField: the resolution must be positive"};
  if (auto ok = check_size(width, height); !ok) return ok.error();
  if (occupied.size() != static_cast<std::size_t>(width) * static_cast<std::size_t>(height))
    return Error{ErrorCode::invalid, "DistanceField: the mask has " +
                                         std::to_string(occupied.size()) + " cells, not " +
                                         std::to_string(width) + " x " + std::to_string(height)};
  if (!in_range(origin))
    return Error{ErrorCode::invalid, "DistanceField: the origin lies beyond the last cell"};
  DistanceField field;
  field.resolution_m_ = resolution_m;
  field.origin_ = origin;
  field.width_ = width;
  field.height_ = height;
  constexpr int kBlock = kernels::kRowBlock;
  field.stride_ = (width + kBlock - 1) / kBlock * kBlock;
  const auto stride = static_cast<std::size_t>(field.stride_);
  field.squared_.assign(stride * static_cast<std::size_t>(height), kFar);
  std::vector<std::uint16_t> columns;
  if (!column_distances(occupied, width, height, columns)) return field;

  const auto& k = kernels::best_kernels();
  std::vector<std::int32_t> scratch(static_cast<std::size_t>(kernels::scratch_length(width)));
  LowerEnvelope envelope;
  for (int y = 0; y < height; ++y) {
    const auto r = static_cast<std::size_t>(y);
    const std::uint16_t* column = columns.data() + r * static_cast<std::size_t>(width);
    std::int32_t* out = field.squared_.data() + r * stride;
    if (!k.row_minimum(column, width, scratch.data(), out)) envelope(column, width, out);
  }
  return field;
}

Result<DistanceField> DistanceField::of_grid(const OccupancyGrid& grid,
                                             double occupied_probability) {
  if (!grid.bounds()) return Error{ErrorCode::invalid, "DistanceField: the map is empty"};
  if (!(occupied_probability >= 0 && occupied_probability <= 1))
    return Error{ErrorCode::invalid, "DistanceField: the probability is out of range"};
  const CellBox box = *grid.bounds();
  if (auto ok = check_size(box.width(), box.height()); !ok) return ok.error();
  const LogOdds least = LogOdds::from_probability(occupied_probability);
  std::vector<std::uint8_t> occupied;
  occupied.reserve(static_cast<std::size_t>(box.cells()));
  for (int y = box.min.y; y <= box.max.y; ++y)
    for (int x = box.min.x; x <= box.max.x; ++x)
      occupied.push_back(grid.observed({x, y}) && grid.log_odds({x, y}) >= least ? 1 : 0);
  return of_mask(occupied, static_cast<int>(box.width()), static_cast<int>(box.height()),
                 grid.resolution_m(), box.min);
}

Result<LikelihoodField> likelihood_field(const DistanceField& distances,
                                         const DistanceLikelihood& likelihood) {
  const double sigma = likelihood.sigma_m / distances.resolution_m();
  const double floor = likelihood.floor_probability;
  if (distances.empty()) return Error{ErrorCode::invalid, "likelihood_field: an empty map"};
  if (!(sigma > 0 && sigma <= 1000))
    return Error{ErrorCode::invalid,
                 "likelihood_field: sigma must be positive, at most 1000 cells"};
  const Cell extent{distances.width() - 1, distances.height() - 1};
  LikelihoodField grid;
  if (auto ok = grid.reset(distances.resolution_m(),
                           {distances.origin(), distances.origin() + extent}, floor);
      !ok)
    return ok.error();
  const auto value_of = [&](std::int32_t square) {
    const double p = floor + (1 - floor) * std::exp(-0.5 * square / (sigma * sigma));
    return static_cast<std::uint16_t>(
        std::lround((std::log(p) - grid.log_floor()) / grid.log_step()));
  };
  // A table of the squares up to where the value rounds to zero, of at most one entry per cell.
  const auto cells = static_cast<std::int64_t>(distances.width()) * distances.height();
  std::vector<std::uint16_t> table;
  do table.push_back(value_of(static_cast<std::int32_t>(table.size())));
  while (table.back() != 0 && std::ssize(table) < cells);
  const auto last = static_cast<std::int32_t>(table.size()) - 1;
  const bool complete = table.back() == 0;
  for (int y = 0; y < distances.height(); ++y) {
    std::uint16_t* out = grid.data() + std::ptrdiff_t{y} * grid.stride();
    for (const std::int32_t square : distances.row(y)) {
      if (complete || square <= last)
        *out++ = table[static_cast<std::size_t>(std::min(square, last))];
      else
        *out++ = square >= DistanceField::kFar ? std::uint16_t{0} : value_of(square);
    }
  }
  return grid;
}

RayCaster::RayCaster(const DistanceField& distances)
    : resolution_m_(distances.resolution_m()),
      origin_(distances.origin()),
      width_(distances.width()),
      height_(distances.height()),
      distance_(static_cast<std::size_t>(width_ + 2) * static_cast<std::size_t>(height_ + 2),
                -1.0F) {
  for (int y = 0; y < height_; ++y) {
    float* out = distance_.data() + std::ptrdiff_t{y + 1} * (width_ + 2) + 1;
    for (const std::int32_t square : distances.row(y))
      *out++ = std::sqrt(static_cast<float>(square));
  }
}

void RayCaster::cast(const SE2d& T_map_laser, std::span<const float> cosines,
                     std::span<const float> sines, double max_range_m,
                     std::span<float> ranges_m) const {
  WAYFARE_EXPECTS(cosines.size() == sines.size() && sines.size() == ranges_m.size(),
                  "cosines, sines and ranges must have the same length");
  const double limit = max_range_m > 0 ? std::min(max_range_m / resolution_m_, kMaxCells) : 0.0;
  const Cell cell = cell_of(T_map_laser.translation(), resolution_m_);
  const Eigen::Vector2d in_cell =
      T_map_laser.translation() / resolution_m_ - Eigen::Vector2d(cell.x, cell.y);
  const Cell at = cell - origin_;
  const bool outside = at.x < 0 || at.y < 0 || at.x >= width_ || at.y >= height_ ||
                       !T_map_laser.translation().allFinite() ||
                       !std::isfinite(T_map_laser.rotation().cos());
  if (outside) {
    std::fill(ranges_m.begin(), ranges_m.end(), static_cast<float>(limit * resolution_m_));
    return;
  }
  const kernels::RayTable table{distance_.data(), width_ + 2, width_, height_};
  const auto c = static_cast<float>(T_map_laser.rotation().cos());
  const auto s = static_cast<float>(T_map_laser.rotation().sin());
  constexpr std::size_t kBatch = 64;
  std::array<float, kBatch> cos_of, sin_of, cells;
  for (std::size_t begin = 0; begin < cosines.size(); begin += kBatch) {
    const std::size_t count = std::min(kBatch, cosines.size() - begin);
    const std::size_t padded = (count + 15) / 16 * 16;
    for (std::size_t i = 0; i < padded; ++i) {
      const std::size_t from = begin + std::min(i, count - 1);
      cos_of[i] = c * cosines[from] - s * sines[from];
      sin_of[i] = s * cosines[from] + c * sines[from];
    }
    kernels::best_kernels().cast(table, at.x, at.y, static_cast<float>(in_cell.x()),
                                 static_cast<float>(in_cell.y()), cos_of.data(), sin_of.data(),
                                 static_cast<int>(padded), static_cast<float>(limit), cells.data());
    for (std::size_t i = 0; i < count; ++i)
      ranges_m[begin + i] = cells[i] * static_cast<float>(resolution_m_);
  }
}

}  // namespace wayfare
