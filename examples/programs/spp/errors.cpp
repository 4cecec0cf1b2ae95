#include <algorithm>
#include <cmath>
#include <set>

#include <wayfare/core/statistics.hpp>

#include "outputs.hpp"

namespace wayfare::examples {
namespace {

/// The reference, interpolated linearly.
std::optional<NavState> reference_at(const NavTrajectory& truth, LogTime time) {
  const auto after =
      std::upper_bound(truth.begin(), truth.end(), time,
                       [](LogTime t, const NavState& state) { return t < state.time; });
  if (after == truth.begin()) return std::nullopt;
  const NavState& a = *(after - 1);
  if (after == truth.end()) return a.time == time ? std::optional(a) : std::nullopt;
  const NavState& b = *after;
  if (b.time - a.time > std::chrono::seconds(2)) return std::nullopt;
  const double w = to_seconds(time - a.time) / to_seconds(b.time - a.time);
  NavState state = a;
  state.time = time;
  state.position = geodetic_from_ecef((1.0 - w) * ecef_from_geodetic(a.position) +
                                      w * ecef_from_geodetic(b.position));
  state.velocity_ned_mps = (1.0 - w) * a.velocity_ned_mps + w * b.velocity_ned_mps;
  return state;
}

struct Errors {
  std::vector<double> horizontal, vertical, speed;
};

void add(const PositionError& e, Errors& errors) {
  errors.horizontal.push_back(e.ned_m.head<2>().norm());
  errors.vertical.push_back(std::abs(e.ned_m.z()));
  if (e.velocity_ned_mps) errors.speed.push_back(e.velocity_ned_mps->norm());
}

void add_row(eval::Table& table, const std::string& name, const Errors& e, bool with_speed) {
  const Summary h = summarise(e.horizontal), v = summarise(e.vertical);
  std::vector<std::string> row = {name,
                                  std::to_string(h.count),
                                  eval::fixed(h.rmse, 3),
                                  eval::fixed(h.median, 3),
                                  eval::fixed(quantile(e.horizontal, 0.95), 2),
                                  eval::fixed(h.max, 2),
                                  eval::fixed(v.rmse, 3)};
  if (with_speed) row.push_back(eval::fixed(summarise(e.speed).rmse, 3));
  table.add_row(std::move(row));
}

/// Rounded to seconds, for epochs of the peer: receivers' clocks differ by milliseconds.
std::int64_t second_of(LogTime t) { return (t.nanoseconds() + 500'000'000) / 1'000'000'000; }

}  // namespace

std::vector<PositionError> errors_of(const SppRun& run) {
  std::vector<PositionError> errors;
  for (const SinglePoint& p : run.points) {
    const std::optional<NavState> truth = reference_at(run.truth, p.instant);
    if (!truth) continue;
    PositionError e;
    e.time = p.instant;
    e.ned_m = ned_from_geodetic(p.position, truth->position);
    e.sigma_m = p.position_covariance_ned_m2.diagonal().cwiseSqrt();
    if (run.truth_has_velocity && p.velocity_ned_mps)
      e.velocity_ned_mps = *p.velocity_ned_mps - truth->velocity_ned_mps;
    errors.push_back(e);
  }
  return errors;
}

eval::Table error_table(const SppRun& run) {
  std::vector<eval::Table::Column> columns = {
      {""},          {"epochs"},       {"horizontal RMS", "m"}, {"median", "m"},
      {"95 %", "m"}, {"largest", "m"}, {"vertical RMS", "m"}};
  const bool speed = run.truth_has_velocity;
  if (speed) columns.push_back({"velocity RMS", "m/s"});
  eval::Table table(columns);
  Errors all, shared, peer;
  std::set<std::int64_t> peers;
  for (const GnssFix& fix : run.peer) {
    const std::optional<NavState> truth = reference_at(run.truth, fix.time);
    if (!truth) continue;
    peers.insert(second_of(fix.time));
    add({fix.time, ned_from_geodetic(fix.position, truth->position), {}, {}}, peer);
  }
  for (const PositionError& e : errors_of(run)) {
    add(e, all);
    if (peers.count(second_of(e.time)) != 0) add(e, shared);
  }
  add_row(table, "answered", all, speed);
  if (run.peer.empty()) return table;
  add_row(table, "at the peer's epochs", shared, speed);
  add_row(table, "peer", peer, speed);
  return table;
}

}  // namespace wayfare::examples
