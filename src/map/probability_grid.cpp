#include <wayfare/map/probability_grid.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace wayfare {
namespace {

using Tiles = OccupancyGrid::Tiles;

/// p · kOne of every log-odds value.
class Probabilities {
 public:
  Probabilities() {
    for (int l = kLeast; l <= -kLeast; ++l) {
      const double odds = std::exp(LogOdds{static_cast<std::int16_t>(l)}.nats());
      table_.push_back(
          static_cast<std::uint16_t>(std::lround(ProbabilityGrid::kOne * odds / (1 + odds))));
    }
  }
  std::uint16_t operator()(std::int16_t log_odds) const {
    return table_[static_cast<std::size_t>(log_odds - kLeast)];
  }

 private:
  static constexpr int kLeast = -std::numeric_limits<std::int16_t>::max();
  std::vector<std::uint16_t> table_;
};

const Probabilities& probabilities() {
  static const Probabilities table;
  return table;
}

}  // namespace

Result<CellBox> ProbabilityGrid::extent(const CellBox& bounds, double unknown_probability,
                                        int margin) {
  if (!(unknown_probability >= 0 && unknown_probability <= 1) || margin < 0)
    return Error{ErrorCode::invalid,
                 "a probability grid: unknown probability or margin out of range"};
  const Cell around{margin, margin};
  const CellBox box{bounds.min - around, bounds.max + around};
  if (auto ok = check_size(box); !ok) return ok.error();
  return box;
}

Result<void> ProbabilityGrid::make(const OccupancyGrid& grid, double unknown_probability,
                                   int margin) {
  const auto refused = [this](Error error) {
    *this = {};
    return error;
  };
  if (!grid.bounds())
    return refused({ErrorCode::invalid, "a probability grid: no cell was observed"});
  const auto box = extent(*grid.bounds(), unknown_probability, margin);
  if (!box) return refused(box.error());
  unknown_ = static_cast<std::uint16_t>(std::lround(kOne * unknown_probability));
  if (auto ok = reset(grid.resolution_m(), *box, unknown_); !ok) return ok;
  copy(grid, *grid.bounds());
  return {};
}

bool ProbabilityGrid::update(const OccupancyGrid& grid, const CellBox& box) {
  if (!covers(box)) return false;
  copy(grid, box);
  return true;
}

void ProbabilityGrid::copy(const OccupancyGrid& grid, const CellBox& box) {
  const Probabilities& p = probabilities();
  const Cell first = Tiles::tile_of(box.min), last = Tiles::tile_of(box.max);
  for (int ty = first.y; ty <= last.y; ++ty)
    for (int tx = first.x; tx <= last.x; ++tx) {
      const Tiles::Tile* tile = grid.tiles().find({tx, ty});
      if (tile == nullptr) continue;
      const Cell corner{tx * Tiles::kSide, ty * Tiles::kSide};
      const int left = std::max(box.min.x, corner.x);
      const int right = std::min(box.max.x, corner.x + Tiles::kSide - 1);
      const int top = std::min(box.max.y, corner.y + Tiles::kSide - 1);
      for (int y = std::max(box.min.y, corner.y); y <= top; ++y) {
        const std::int16_t* from = tile->data() + Tiles::offset_in_tile({left, y});
        std::uint16_t* to =
            data() + std::ptrdiff_t{y - origin().y} * stride() + (left - origin().x);
        for (int n = right - left + 1; n > 0; --n, ++from, ++to)
          *to = *from == OccupancyGrid::kUnknown ? unknown_ : p(*from);
      }
    }
}

}  // namespace wayfare
