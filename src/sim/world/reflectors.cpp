#include <wayfare/sim/radar.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace wayfare::sim {
namespace {

using Eigen::Vector2d;

enum ReflectorStream : std::uint64_t { kWalls, kCorners, kHidden, kFloor };

Vector2d across(const Segment& wall) {
  const Vector2d along = (wall.b_m - wall.a_m).normalized();
  return {-along.y(), along.x()};
}

class Furnisher {
 public:
  Furnisher(const FloorPlan& plan, const Interior& interior, const FurnishParams& params)
      : plan_(plan), interior_(interior), params_(params) {}

  std::vector<Reflector> furnish(const Rng& rng) {
    constexpr double kMost = 1e7;
    WAYFARE_EXPECTS(expected_number() <= kMost, "a plan has up to ten million reflectors");
    Rng walls = rng.stream(kWalls), corners = rng.stream(kCorners);
    for (const Segment& wall : plan_.segments()) add_wall(wall, walls);
    add_corners(corners);
    for (const Vector2d& frame : interior_.frames_m)
      add(frame, params_.door_frame, {0.0, 0.0}, corners);
    Rng hidden = rng.stream(kHidden), floor = rng.stream(kFloor);
    add_hidden(hidden);
    const std::size_t may_have_ghosts = reflectors_.size();
    add_floor(floor);
    add_diffuse(floor);
    for (std::size_t i = 0; i < may_have_ghosts; ++i) add_ghosts(reflectors_[i]);
    return std::move(reflectors_);
  }

 private:
  // Without corners, door frames and ghosts; infinite or NaN where the parameters are.
  [[nodiscard]] double expected_number() const {
    const FurnishParams& p = params_;
    const auto per_m = [](const FurnishParams::Kind& kind, double share) {
      return kind.spacing_m > 0.0 ? share / kind.spacing_m : 0.0;
    };
    const double per_wall_m =
        per_m(p.plaster, 1.0) + per_m(p.panel, 1.0) + per_m(p.strut, p.strut_share);
    double walls_m = 0.0;
    for (const Segment& wall : plan_.segments()) walls_m += (wall.b_m - wall.a_m).norm();
    constexpr double kInPatch = 63.0;  // 20 π, for each reflector per m² of the floor
    const double per_m2 =
        std::abs(p.hidden_per_m2) + std::abs(p.diffuse_per_m2) +
        std::abs(p.floor_per_m2) * (1.0 + kInPatch * std::abs(p.floor_patches_per_m2));
    return per_wall_m * walls_m + per_m2 * extent_m2();
  }

  void add(const Vector2d& at_m, const FurnishParams::Kind& kind, const Vector2d& normal,
           Rng& rng) {
    Reflector r;
    r.at_m = at_m;
    r.strength_db = rng.normal(kind.strength_db, kind.spread_db);
    r.normal = normal;
    r.sharpness = kind.sharpness;
    reflectors_.push_back(r);
  }

  void add_wall(const Segment& wall, Rng& rng) {
    add_along(wall, params_.plaster, 1.0, rng);
    add_along(wall, params_.panel, 1.0, rng);
    add_along(wall, params_.strut, params_.strut_share, rng);
  }

  // At random positions with exponential spacing: a wall's features are not periodic.
  void add_along(const Segment& wall, const FurnishParams::Kind& kind, double share, Rng& rng) {
    if (kind.spacing_m <= 0.0) return;
    const double length_m = (wall.b_m - wall.a_m).norm();
    const Vector2d along = (wall.b_m - wall.a_m) / length_m, normal = across(wall);
    const auto gap_m = [&] { return -std::log(1.0 - rng.uniform()) * kind.spacing_m / share; };
    for (double at = gap_m(); at < length_m; at += gap_m())
      add(wall.a_m + at * along, kind, normal, rng);
  }

  void add_corners(Rng& rng) {
    const auto walls = plan_.segments();
    for (std::size_t i = 0; i < walls.size(); ++i) {
      if ((walls[i].b_m - walls[i].a_m).norm() < params_.corner_wall_m) continue;
      for (std::size_t k = i + 1; k < walls.size(); ++k) {
        if ((walls[k].b_m - walls[k].a_m).norm() < params_.corner_wall_m) continue;
        for (const Vector2d& end : {walls[i].a_m, walls[i].b_m})
          if (std::min((end - walls[k].a_m).norm(), (end - walls[k].b_m).norm()) < 1e-6)
            add(end, params_.corner, {0.0, 0.0}, rng);
      }
    }
  }

  [[nodiscard]] Vector2d anywhere(Rng& rng) const {
    const Vector2d lower = plan_.lower_corner_m(), upper = plan_.upper_corner_m();
    const double x = rng.uniform(lower.x() - 2.0, upper.x() + 2.0);
    return {x, rng.uniform(lower.y() - 2.0, upper.y() + 2.0)};
  }
  [[nodiscard]] double extent_m2() const {
    return (plan_.upper_corner_m() - plan_.lower_corner_m() + Vector2d(4.0, 4.0)).prod();
  }
  [[nodiscard]] std::size_t number(double per_m2) const {
    return static_cast<std::size_t>(std::lround(std::max(per_m2, 0.0) * extent_m2()));
  }

  void add_hidden(Rng& rng) {
    for (std::size_t i = number(params_.hidden_per_m2); i > 0; --i) {
      const Vector2d at = anywhere(rng);
      const double strength_db = rng.normal(params_.hidden_strength_db, params_.hidden_spread_db);
      if (is_open(at)) continue;
      reflectors_.push_back({at, strength_db});
    }
  }

  [[nodiscard]] bool is_open(const Vector2d& at) const {
    return std::any_of(interior_.open_m.begin(), interior_.open_m.end(),
                       [&](const Vector2d& open) { return !plan_.blocks(open, at); });
  }

  void add_diffuse(Rng& rng) {
    const FurnishParams::Kind kind{0.0, params_.diffuse_strength_db, params_.diffuse_spread_db,
                                   0.0};
    for (std::size_t i = number(params_.diffuse_per_m2); i > 0; --i)
      add(anywhere(rng), kind, {0.0, 0.0}, rng);
  }

  void add_bump(const Vector2d& at, Rng& rng) {
    add(at, {0.0, params_.floor_strength_db, params_.floor_spread_db, 0.0}, {0.0, 0.0}, rng);
    reflectors_.back().max_range_m = params_.floor_max_range_m;
  }

  void add_floor(Rng& rng) {
    for (std::size_t i = number(params_.floor_per_m2); i > 0; --i) add_bump(anywhere(rng), rng);
    const auto in_a_patch =
        static_cast<int>(std::lround(20.0 * params_.floor_per_m2 * std::numbers::pi));
    for (std::size_t i = number(params_.floor_patches_per_m2); i > 0; --i) {
      const Vector2d centre = anywhere(rng);
      for (int k = 0; k < in_a_patch; ++k) {
        const double radius = std::sqrt(rng.uniform()), angle = rng.uniform(-3.2, 3.2);
        add_bump(centre + radius * Vector2d(std::cos(angle), std::sin(angle)), rng);
      }
    }
  }

  // By value: the list grows.  NOLINTNEXTLINE(performance-unnecessary-value-param)
  void add_ghosts(const Reflector source) {
    if (source.strength_db < params_.ghost_from_db) return;
    const auto walls = plan_.segments();
    for (std::size_t w = 0; w < walls.size(); ++w) {
      if ((walls[w].b_m - walls[w].a_m).norm() < params_.ghost_wall_m) continue;
      const Vector2d normal = across(walls[w]);
      const double distance = normal.dot(source.at_m - walls[w].a_m);
      if (std::abs(distance) < 0.1 || std::abs(distance) > params_.ghost_max_distance_m) continue;
      Reflector ghost = source;
      ghost.at_m -= 2.0 * distance * normal;
      ghost.normal -= 2.0 * normal.dot(source.normal) * normal;
      ghost.strength_db -= params_.ghost_loss_db;
      ghost.mirror = static_cast<std::uint32_t>(w);
      reflectors_.push_back(ghost);
    }
  }

  const FloorPlan& plan_;
  const Interior& interior_;
  const FurnishParams& params_;
  std::vector<Reflector> reflectors_;
};

}  // namespace

std::vector<Reflector> furnish(const FloorPlan& plan, const Interior& interior,
                               const FurnishParams& params, const Rng& rng) {
  return Furnisher(plan, interior, params).furnish(rng);
}

}  // namespace wayfare::sim
