#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <wayfare/nav/gnss_ins.hpp>

#include "nav/gnss_ins/any_filter.hpp"
#include "nav/gnss_ins/replay.hpp"

namespace wayfare {

namespace {

/// Of readings, range epochs and others.
template <class T>
void sort_by_time(std::vector<T>& all) {
  std::stable_sort(all.begin(), all.end(), [](const T& a, const T& b) { return a.time < b.time; });
}

/// The filter before the first reading of a block of them, and how far it has come.
struct Checkpoint {
  GnssIns filter;
  std::size_t ranges, fixes, wheels;
};

class Smoothing {
 public:
  Smoothing(GnssInsRecording recording, const GnssInsOptions& options)
      : recording_(std::move(recording)), options_(options) {
    sort_by_time(recording_.imu);
    sort_by_time(recording_.ranges);
    sort_by_time(recording_.fixes);
    sort_by_time(recording_.wheels);
    // Nothing is late any more; without replay the filter is small.
    options_.max_lateness_s = 0.0;
    options_.smoothing_lag_s = 0.0;
    // A checkpoint is about 25 kB, the steps of a reading 8 kB: the sum is least there.
    block_ = std::max<std::size_t>(
        1000, static_cast<std::size_t>(std::sqrt(3.0 * static_cast<double>(count()))));
  }

  [[nodiscard]] std::size_t count() const { return recording_.imu.size(); }
  [[nodiscard]] std::size_t blocks() const { return (count() + block_ - 1) / block_; }

  /// Filters block b, the next.
  void forward(std::size_t b) {
    checkpoints_.push_back({replay_.filter, replay_.ranges, replay_.fixes, replay_.wheels});
    run(replay_, b);
    replay_.collect();
    started_ = started_ || !replay_.result.points.empty();
    replay_.result.points.clear();
  }
  /// Smooths block b, the one before that of the last call.
  void backward(std::size_t b, const nav::SmoothedSink& sink) {
    Checkpoint& from = checkpoints_[b];
    nav::Replay replay{recording_, std::move(from.filter), offset()};
    checkpoints_.pop_back();
    replay.ranges = from.ranges, replay.fixes = from.fixes, replay.wheels = from.wheels;
    nav::AnyInsFilter& filter = detail::InsHistoryAccess::filter(replay.filter);
    filter.keep();
    run(replay, b);
    filter.smooth(adjoint_, sink);
  }
  [[nodiscard]] const GnssIns& filter() const { return replay_.filter; }
  /// Whether there is any solution.
  [[nodiscard]] bool has_started() const { return started_; }
  /// Innovations and notices of the filter.
  [[nodiscard]] GnssInsResult finish() { return replay_.finish(); }

 private:
  [[nodiscard]] Duration offset() const { return from_seconds(options_.imu_time_offset_s); }
  [[nodiscard]] GnssIns started() const {
    GnssIns filter(options_);
    if (recording_.start) filter.start(*recording_.start);
    return filter;
  }
  void run(nav::Replay& replay, std::size_t b) const {
    const std::size_t end = std::min((b + 1) * block_, count());
    for (std::size_t i = b * block_; i < end; ++i) replay.step(recording_.imu[i]);
  }

  GnssInsRecording recording_;
  GnssInsOptions options_;
  std::size_t block_;
  nav::Replay replay_{recording_, started(), offset()};
  std::vector<Checkpoint> checkpoints_;
  nav::InsAdjoint adjoint_;
  bool started_ = false;
};

Result<GnssInsResult> smooth_once(const GnssInsRecording& recording, const GnssInsOptions& options,
                                  const GnssInsProgress& progress, const std::stop_token& stop,
                                  const std::function<void(const GnssInsEstimate&)>& each) {
  Smoothing smoothing(recording, options);
  const std::size_t blocks = smoothing.blocks();
  const auto report = [&](double done) {
    if (progress) progress(done / (3.0 * static_cast<double>(blocks)));
  };
  for (std::size_t b = 0; b < blocks; ++b) {
    if (stop.stop_requested()) return nav::stopped();
    report(static_cast<double>(b));
    smoothing.forward(b);
  }
  if (!smoothing.has_started()) return nav::never_started(smoothing.filter());
  GnssInsResult result = smoothing.finish();
  for (std::size_t b = blocks; b-- > 0;) {
    if (stop.stop_requested()) return nav::stopped();
    report(static_cast<double>(blocks) + 2.0 * static_cast<double>(blocks - 1 - b));
    smoothing.backward(b, [&](const GnssInsPoint& point, const auto& estimate) {
      result.points.push_back(point);
      if (each) each(estimate());
    });
  }
  std::reverse(result.points.begin(), result.points.end());
  if (progress) progress(1.0);
  return result;
}

}  // namespace

Result<GnssInsResult> smooth_gnss_ins(const GnssInsRecording& recording,
                                      const GnssInsOptions& options,
                                      const GnssInsProgress& progress, std::stop_token stop,
                                      const std::function<void(const GnssInsEstimate&)>& each) {
  if (options.correlated.share > 0.0)
    return Error{ErrorCode::invalid, "with correlated errors the filter cannot be smoothed"};
  return nav::with_coarse_start(recording, options, [&](const GnssInsOptions& o) {
    return smooth_once(recording, o, progress, stop, each);
  });
}

}  // namespace wayfare
