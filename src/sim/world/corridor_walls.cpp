#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <wayfare/sim/worlds.hpp>

namespace wayfare::sim {
namespace {

constexpr double kDoor_m = 0.9;
constexpr double kPane_m = 1.5;
constexpr double kRoom_m = 3.0;

/// A straight wall in coordinates of its start: metres along it, and into the corridor.
class WallBuilder {
 public:
  WallBuilder(const Eigen::Vector2d& a, const Eigen::Vector2d& b, std::vector<Segment>& walls)
      : a_(a), along_((b - a).normalized()), inward_(-along_.y(), along_.x()), walls_(walls) {}

  [[nodiscard]] Eigen::Vector2d at(double along_m, double inward_m) const {
    return a_ + along_m * along_ + inward_m * inward_;
  }
  /// Points (along, inward), joined by walls.
  void path(const std::vector<std::pair<double, double>>& places) {
    for (std::size_t i = 1; i < places.size(); ++i)
      walls_.push_back(
          {at(places[i - 1].first, places[i - 1].second), at(places[i].first, places[i].second)});
  }
  void person(double along_m, double inward_m) {
    std::vector<std::pair<double, double>> round;
    for (int k = 0; k <= 8; ++k) {
      const double angle = 0.25 * std::numbers::pi * k;
      round.emplace_back(along_m + 0.15 * std::cos(angle), inward_m + 0.15 * std::sin(angle));
    }
    path(round);
  }

 private:
  Eigen::Vector2d a_, along_, inward_;
  std::vector<Segment>& walls_;
};

/// An interruption of a wall, from `begin` over `width`: a recess, or a room.
struct Opening {
  double begin = 0.0, width = 0.0;
  bool room = false, leaf = false;
};

std::vector<Opening> openings(double length, const CorridorFurniture& f, Rng& rng) {
  std::vector<Opening> all;
  if (f.door_spacing_m > 0.0) {
    for (double s = f.door_spacing_m * rng.uniform(0.2, 0.8); s + kDoor_m + 0.1 < length;
         s += f.door_spacing_m) {
      const bool open = rng.uniform() < f.open_share;
      all.push_back({s, kDoor_m, open, open && rng.uniform() < 0.5});
    }
  }
  const auto panes = static_cast<int>(std::lround(f.glass_per_m * length));
  for (int i = 0; i < panes; ++i)
    all.push_back({rng.uniform(0.1, std::max(0.1, length - kPane_m - 0.1)), kPane_m, true, false});
  std::sort(all.begin(), all.end(),
            [](const Opening& a, const Opening& b) { return a.begin < b.begin; });
  return all;
}

void place(WallBuilder& wall, const Opening& o, const CorridorFurniture& f) {
  const double end = o.begin + o.width;
  if (!o.room) {
    wall.path({{o.begin, 0.0}, {o.begin, -f.recess_m}, {end, -f.recess_m}, {end, 0.0}});
    return;
  }
  wall.path({{o.begin, 0.0}, {o.begin, -kRoom_m}, {end, -kRoom_m}, {end, 0.0}});
  // The leaf of an open door, at 60°.
  if (o.leaf) wall.path({{o.begin, 0.0}, {o.begin + 0.45, -0.78}});
}

}  // namespace

void append_furnished_wall(const Eigen::Vector2d& a_m, const Eigen::Vector2d& b_m, double depth_m,
                           const CorridorFurniture& f, Rng& rng, std::vector<Segment>& walls) {
  const double length = (b_m - a_m).norm();
  WallBuilder wall(a_m, b_m, walls);
  double from = 0.0;
  for (const Opening& o : openings(length, f, rng)) {
    if (o.begin < from + 0.05 || o.begin + o.width > length - 0.05) continue;
    wall.path({{from, 0.0}, {o.begin, 0.0}});
    place(wall, o, f);
    from = o.begin + o.width;
  }
  wall.path({{from, 0.0}, {length, 0.0}});
  const auto boxes = static_cast<int>(std::lround(f.boxes_per_m * length));
  for (int i = 0; i < boxes; ++i) {
    const double s = rng.uniform(0.0, length - 0.5), width = rng.uniform(0.2, 0.5);
    const double deep = std::min(depth_m, rng.uniform(0.15, 0.45));
    wall.path({{s, 0.01}, {s, deep}, {s + width, deep}, {s + width, 0.01}});
  }
  const auto people = static_cast<int>(std::lround(f.people_per_m * length));
  for (int i = 0; i < people; ++i)
    wall.person(rng.uniform(0.2, length - 0.2), rng.uniform(0.16, std::max(0.16, depth_m - 0.16)));
}

Result<FloorPlan> three_corridors(const CorridorsParams& p, const Rng& rng) {
  const double h = 0.5 * p.width_m, back = 1.5;
  const double x1 = p.lengths_m[0], y1 = p.lengths_m[1], x2 = x1 + p.lengths_m[2];
  // Once round the inside, with the corridor on the left.
  const std::vector<Eigen::Vector2d> corners = {
      {-back, -h},         {x1 + h, -h},     {x1 + h, y1 - h}, {x2 + back, y1 - h},
      {x2 + back, y1 + h}, {x1 - h, y1 + h}, {x1 - h, h},      {-back, h}};
  std::vector<Segment> walls;
  const double depth = std::max(0.0, h - 0.7);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    Rng own = rng.stream(i);
    // The ends of the building and the walls that face a corridor have no furniture.
    const Eigen::Vector2d &a = corners[i], &b = corners[(i + 1) % corners.size()];
    const CorridorFurniture plain{.door_spacing_m = 0.0};
    const bool is_end = (b - a).norm() < p.width_m + 0.1;
    append_furnished_wall(a, b, depth, is_end ? plain : p.furniture, own, walls);
  }
  return FloorPlan::from_segments(std::move(walls));
}

}  // namespace wayfare::sim
