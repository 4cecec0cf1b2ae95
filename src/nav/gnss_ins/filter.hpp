#pragma once

// The filter of GnssIns with its memory.

#include <algorithm>
#include <array>
#include <deque>
#include <memory>
#include <variant>
#include <vector>

#include <wayfare/inertial/detail/sample_clock.hpp>

#include "nav/gnss_ins/any_filter.hpp"
#include "nav/gnss_ins/arrivals.hpp"
#include "nav/gnss_ins/ins_engine.hpp"
#include "nav/gnss_ins/ins_history.hpp"
#include "nav/gnss_ins/ins_start.hpp"
#include "nav/gnss_ins/measurement_log.hpp"
#include "nav/gnss_ins/plausible.hpp"

namespace wayfare::nav {

/// Recent measurements in order of time, and snapshots for replay. `Further`: of InsEngine.
template <class... Further>
class InsFilterWith final : public AnyInsFilter {
 public:
  using Engine = InsEngine<Further...>;
  using History = InsHistory<typename Engine::State>;

  explicit InsFilterWith(const GnssInsOptions& options)
      : options_(options), starter_(options), coarse_(options) {
    // Late measurements are replayed: what they change is kept as well.
    if (options.smoothing_lag_s > 0.0 && options.correlated.share <= 0.0)
      history_.open(from_seconds(std::max(options.smoothing_lag_s, options.max_lateness_s + 1.0)));
  }

  [[nodiscard]] std::unique_ptr<AnyInsFilter> copy() const override {
    return std::make_unique<InsFilterWith>(*this);
  }

  void start(const GnssInsStart& start) override {
    if (!plausible(start))
      return events_.note(start.nav.time,
                          "the given start is implausible: not finite, not on the Earth, faster "
                          "than 100 km/s, or of a negative standard deviation: it is not used");
    clear();
    seen_ = {};
    given_start_ = start;
  }
  [[nodiscard]] bool started() const override { return engine_.has_value(); }
  [[nodiscard]] std::string missing() const override {
    if (engine_) return {};
    if (given_start_) return "there are no inertial readings at or after the given start's time";
    return starter_.missing();
  }

  Result<void> add(const ImuSample& sample) override {
    ImuSample s = sample;
    s.time += from_seconds(options_.imu_time_offset_s);
    if (!plausible(s))
      return refused(ErrorCode::invalid, s.time, "an inertial reading is implausible");
    const SampleClock::Verdict order = imu_clock_.check(s.time);
    if (order == SampleClock::Verdict::late) {
      return refused(ErrorCode::invalid, s.time,
                     s.time == last_imu_->time ? "an inertial reading arrived twice"
                                               : "an inertial reading is out of order");
    }
    if (last_imu_ && order == SampleClock::Verdict::first) {
      events_.note(s.time, "the unit's clock was set back: reinitialising");
      forget();
      last_imu_.reset();
      seen_ = {};
    }
    const double gap_s = last_imu_ ? to_seconds(s.time - last_imu_->time) : 0.0;
    const auto missing = [gap_s] {
      return "no inertial readings for " + std::to_string(gap_s) + " s: ";
    };
    if (engine_ && gap_s > options_.max_imu_gap_s) {
      events_.note(last_imu_->time, missing() + "reinitialising");
      forget();
    } else if (engine_ && is_gap(*last_imu_, s)) {
      events_.note(last_imu_->time, missing() + "bridged");
    }
    interval_.add(gap_s);
    if (!engine_) try_given_start(s);
    last_imu_ = s;
    if (seeks_start()) {
      starter_.add(s);
      if (starts_coarsely()) coarse_.add(s);
    }
    if (engine_) insert(s);
    return {};
  }

  Result<void> add(const RangeEpoch& epoch) override { return add_gnss(epoch, seen_[0]); }
  Result<void> add(const GnssFix& fix) override { return add_gnss(fix, seen_[1]); }
  Result<void> add(const WheelSpeed& wheels) override {
    if (!options_.odometer)
      return refused(ErrorCode::invalid, wheels.time, "wheel speeds need GnssInsOptions::odometer");
    if (!plausible(wheels))
      return refused(ErrorCode::invalid, wheels.time, "a wheel speed is implausible");
    ArrivalTimes& seen = seen_[2];
    if (!engine_ || seen.follows_closely(wheels.time)) return {};
    if (auto in_time = accept(wheels.time, seen, "a wheel speed arrived twice"); !in_time)
      return in_time;
    insert(wheels);
    return {};
  }
  [[nodiscard]] GnssInsEstimate estimate() const override {
    return engine().view().estimate(options_.q_body_imu);
  }
  [[nodiscard]] GnssInsPoint point() const override {
    return engine().view().point(options_.q_body_imu);
  }
  [[nodiscard]] EventLog& events() override { return events_; }

  void keep() override { history_.open(Duration::max() / 2); }
  void smooth(InsAdjoint& adjoint, const SmoothedSink& sink) const override {
    history_.smooth(adjoint, options_.q_body_imu, sink);
  }

  [[nodiscard]] std::optional<GnssInsEstimate> lagged() const override {
    if (!engine_ || options_.correlated.share > 0.0) return std::nullopt;
    return history_.estimate(engine_->time() - from_seconds(options_.smoothing_lag_s),
                             options_.q_body_imu);
  }

 private:
  struct Snapshot {
    std::size_t done;
    Engine engine;
    typename History::Place recorded;
  };

  [[nodiscard]] const Engine& engine() const {
    WAYFARE_EXPECTS(engine_.has_value(), "the filter has started");
    return *engine_;
  }

  template <class Gnss>
  Result<void> add_gnss(const Gnss& m, ArrivalTimes& seen) {
    if (!plausible(m)) return refused(ErrorCode::invalid, m.time, "no usable measurement");
    if (!engine_) {
      if (given_start_) return refused(ErrorCode::not_found, m.time, "before the given start");
      if (seen.contains(m.time))
        return refused(ErrorCode::invalid, m.time, "an epoch arrived twice");
      seen.restart(m.time);
      const auto start = find_start(m);
      if (start && last_imu_) begin(*start, *last_imu_);
      return {};
    }
    if (auto in_time = accept(m.time, seen, "an epoch arrived twice"); !in_time) return in_time;
    if (heading_unknown_ && m.time >= engine_->time() - from_seconds(1.0))
      if (const auto start = find_start(m)) return align(*start), Result<void>{};
    insert(m);
    return {};
  }

  /// Errors: too late, far ahead, or among `seen`, to which it is added.
  Result<void> accept(LogTime time, ArrivalTimes& seen, const char* twice) {
    const LogTime oldest = snapshots_.empty() ? engine_->time() : snapshots_.front().engine.time();
    if (time < oldest) return refused(ErrorCode::invalid, time, "too late");
    if (seen.contains(time)) return refused(ErrorCode::invalid, time, twice);
    if (last_imu_ && time - last_imu_->time > from_seconds(60.0))
      return refused(ErrorCode::invalid, time, "far ahead of the inertial readings");
    seen.add(time, oldest);
    return {};
  }

  /// Not started, or without heading.
  [[nodiscard]] bool seeks_start() const { return !engine_ || heading_unknown_; }
  [[nodiscard]] bool starts_coarsely() const {
    return options_.start_without_velocity || heading_unknown_;
  }

  template <class Gnss>
  std::optional<GnssInsStart> find_start(const Gnss& m) {
    const auto position = nav::Starter::position_of(m);
    auto start = starter_.add(m, position);
    if (start || !position || !starts_coarsely()) return start;
    return coarse_.add(*position, !engine_);
  }

  /// The first motion gives the heading: starts again, with the gyro biases found at rest.
  void align(GnssInsStart start) {
    const GnssInsEstimate e = engine_->view().estimate(options_.q_body_imu);
    if (start.gyro_bias_sigma_radps == 0.0) {
      start.gyro_bias_radps = e.gyro_bias_radps;
      start.gyro_bias_sigma_radps =
          std::sqrt(e.covariance.diagonal().segment<3>(ins_state::kGyroBias).maxCoeff());
    }
    begin(start, *last_imu_);
    events_.note(start.nav.time, "the heading is known from motion");
  }

  void clear() {
    history_.restart();
    unmarked_ = false;
    engine_.reset();
    heading_unknown_ = false;
    log_.clear();
    snapshots_.clear();
    done_ = 0;
  }

  void forget() {
    clear();
    starter_ = nav::Starter(options_);
    coarse_ = nav::CoarseStarter(options_);
  }

  void begin(const GnssInsStart& start, const ImuSample& first) {
    clear();
    engine_.emplace(options_, start, first);
    heading_unknown_ = start.heading_sigma_rad > nav::kUnknownHeading_rad;
    snapshots_.push_back({0, *engine_, history_.end()});
    events_.note(start.nav.time, heading_unknown_
                                     ? "inertial navigation started, the heading is unknown"
                                     : "inertial navigation started");
    given_start_.reset();
  }

  void try_given_start(const ImuSample& s) {
    if (!given_start_ || s.time < given_start_->nav.time) return;
    if (s.time - given_start_->nav.time > from_seconds(options_.max_imu_gap_s)) {
      events_.note(s.time, "the given start is too long before the inertial readings");
      given_start_.reset();
      return;
    }
    begin(*given_start_, s);
  }

  /// Puts it in order of time, and processes what can be.
  void insert(const nav::Measurement& m) {
    const auto at = nav::place_of(m, log_);
    const auto index = static_cast<std::size_t>(at - log_.begin());
    log_.insert(at, nav::LogEntry{m});
    if (index < done_) rewind(index);
    run();
  }

  /// Restores the newest snapshot before entry `index`.
  void rewind(std::size_t index) {
    while (snapshots_.size() > 1 && snapshots_.back().done > index) snapshots_.pop_back();
    engine_ = snapshots_.back().engine;
    done_ = snapshots_.back().done;
    history_.truncate(snapshots_.back().recorded);
    unmarked_ = false;
  }

  void run() {
    while (done_ < log_.size() && step()) {
    }
    mark();
    prune();
  }

  /// Marks the estimate by all measurements up to the newest reading, once.
  void mark() {
    if (unmarked_) history_.mark(engine_->view());
    unmarked_ = false;
  }

  /// False if the next measurement must wait for an inertial reading after it.
  bool step() {
    engine_->record_to(history_.tape());
    nav::LogEntry& entry = log_[done_];
    const LogTime t = nav::time_of(entry.measurement);
    if (t > engine_->time()) mark();
    if (!nav::is_imu(entry.measurement) && t > engine_->time() && !advance_to(t)) return false;
    events_.open = !entry.processed;
    std::visit([this](const auto& m) { this->process(m); }, entry.measurement);
    events_.open = true;
    entry.processed = true;
    ++done_;
    if (nav::is_imu(entry.measurement)) {
      unmarked_ = true;
      if (snapshots_.empty() ||
          engine_->time() - snapshots_.back().engine.time() > from_seconds(0.25)) {
        if (!engine_->on_earth()) {
          events_.note(t, "the solution is off the Earth: reinitialising", true);
          forget();
          return true;
        }
        snapshots_.push_back({done_, *engine_, history_.end()});
      }
    } else if (engine_->lost()) {
      events_.note(t, "the solution has diverged from the measurements: reinitialising", true);
      forget();
    }
    return true;
  }

  /// Advances by interpolation to the next inertial reading, if there is one.
  bool advance_to(LogTime t) {
    const auto next =
        std::find_if(log_.begin() + static_cast<std::ptrdiff_t>(done_), log_.end(),
                     [](const nav::LogEntry& e) { return nav::is_imu(e.measurement); });
    if (next == log_.end()) return false;
    const auto& s = std::get<ImuSample>(next->measurement);
    const ImuSample last = engine_->last_sample();
    engine_->advance(nav::interpolate(last, s, t), is_gap(last, s), events_);
    return true;
  }

  void process(const ImuSample& s) {
    engine_->advance(s, is_gap(engine_->last_sample(), s), events_);
  }
  template <class Gnss>
  void process(const Gnss& m) {
    engine_->apply(m, events_);
  }

  [[nodiscard]] bool is_gap(const ImuSample& a, const ImuSample& b) const {
    return interval_.is_gap(to_seconds(b.time - a.time));
  }

  void prune() {
    if (!engine_) return;
    const LogTime limit = engine_->time() - from_seconds(options_.max_lateness_s);
    while (snapshots_.size() > 1 && snapshots_[1].engine.time() <= limit) snapshots_.pop_front();
    const std::size_t drop = snapshots_.front().done;
    log_.erase(log_.begin(), log_.begin() + static_cast<std::ptrdiff_t>(drop));
    const typename History::Place removed = history_.drop_old();
    for (Snapshot& k : snapshots_) k.done -= drop, k.recorded -= removed;
    done_ -= drop;
  }

  GnssInsOptions options_;
  nav::Starter starter_;
  nav::CoarseStarter coarse_;
  bool heading_unknown_ = false;  ///< of the engine
  std::optional<GnssInsStart> given_start_;
  std::optional<Engine> engine_;
  std::optional<ImuSample> last_imu_;
  SampleClock imu_clock_{1.0};
  /// Times of accepted ranges, fixes and wheel speeds, while they could still be replayed or start
  /// the filter.
  std::array<ArrivalTimes, 3> seen_;
  ReadingInterval interval_;
  nav::MeasurementLog log_;
  std::size_t done_ = 0;
  std::deque<Snapshot> snapshots_;
  History history_;
  bool unmarked_ = false;
  EventLog events_;
};

}  // namespace wayfare::nav
