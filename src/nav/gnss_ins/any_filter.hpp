#pragma once

// The filter of GnssIns for any set of states, and what it needs of it.

#include <any>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include <wayfare/nav/gnss_ins.hpp>

#include "nav/gnss_ins/event_log.hpp"

namespace wayfare::nav {

/// A SmootherAdjoint of the filter's state; empty: none yet.
using InsAdjoint = std::any;
/// Called with a smoothed point, and what gives its estimate.
using SmoothedSink =
    std::function<void(const GnssInsPoint&, const std::function<GnssInsEstimate()>&)>;

/// As GnssIns, see there.
class AnyInsFilter {
 public:
  virtual ~AnyInsFilter() = default;
  [[nodiscard]] virtual std::unique_ptr<AnyInsFilter> copy() const = 0;

  virtual void start(const GnssInsStart& start) = 0;
  [[nodiscard]] virtual bool started() const = 0;
  [[nodiscard]] virtual std::string missing() const = 0;
  virtual Result<void> add(const ImuSample& sample) = 0;
  virtual Result<void> add(const RangeEpoch& epoch) = 0;
  virtual Result<void> add(const GnssFix& fix) = 0;
  virtual Result<void> add(const WheelSpeed& wheels) = 0;
  [[nodiscard]] virtual GnssInsEstimate estimate() const = 0;
  [[nodiscard]] virtual GnssInsPoint point() const = 0;
  [[nodiscard]] virtual std::optional<GnssInsEstimate> lagged() const = 0;
  [[nodiscard]] virtual EventLog& events() = 0;

  /// Keeps all that the filter does from now on.
  virtual void keep() = 0;
  /// Calls `sink` with each smoothed estimate since, the newest first. `adjoint` is that of the end
  /// and becomes that of the beginning.
  virtual void smooth(InsAdjoint& adjoint, const SmoothedSink& sink) const = 0;

 protected:
  AnyInsFilter() = default;
  AnyInsFilter(const AnyInsFilter&) = default;
  AnyInsFilter& operator=(const AnyInsFilter&) = default;
};

/// With the states that `options` asks for.
[[nodiscard]] std::unique_ptr<AnyInsFilter> make_ins_filter(const GnssInsOptions& options);

}  // namespace wayfare::nav

namespace wayfare::detail {

/// The filter of a GnssIns, for smoothing over a whole recording.
struct InsHistoryAccess {
  /// See nav::AnyInsFilter.
  static nav::AnyInsFilter& filter(GnssIns& ins);
};

}  // namespace wayfare::detail
