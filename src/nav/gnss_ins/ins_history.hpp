#pragma once

// What smoothing needs of the past: the filter's tape, and what its marks were relative to.

#include <any>
#include <chrono>
#include <cstddef>
#include <deque>
#include <optional>
#include <utility>

#include <wayfare/core/geodesy.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/filter/smoother.hpp>

#include "nav/gnss_ins/any_filter.hpp"
#include "nav/gnss_ins/ins_view.hpp"

namespace wayfare::nav {

template <class State>
class InsHistory {
 public:
  using Tape = SmootherTape<State>;
  using Place = typename Tape::Place;
  using View = InsView<State>;

  /// What a mark's state is relative to.
  struct MarkPlace {
    LogTime time;
    LocalTangentPlane plane;
    double clock_anchor_m;
  };

  /// Records from now on; `kept`: marks older than that before the newest are removed.
  void open(Duration kept) { kept_ = kept; }
  /// Nothing while it is not open.
  [[nodiscard]] Tape* tape() { return kept_ ? &tape_ : nullptr; }
  [[nodiscard]] Place end() const { return tape_.end(); }

  void restart() {
    if (kept_) tape_.restart();
  }
  void mark(const View& now) {
    if (!kept_) return;
    tape_.mark(now.x, now.p);
    places_.push_back({now.time, now.plane, now.clock_anchor_m});
  }
  void truncate(const Place& place) {
    tape_.truncate(place);
    places_.resize(place.marks);
  }
  /// Removes marks that are too old, a second of them at a time; returns what was removed.
  Place drop_old() {
    if (!kept_ || places_.empty() ||
        places_.back().time - places_.front().time < *kept_ + std::chrono::seconds(1))
      return {};
    std::size_t old = 0;
    while (old + 1 < places_.size() && places_.back().time - places_[old + 1].time >= *kept_) ++old;
    places_.erase(places_.begin(), places_.begin() + static_cast<std::ptrdiff_t>(old));
    return tape_.drop_marks(old);
  }

  /// A smoothed estimate.
  struct Smoothed {
    const MarkPlace& place;
    typename Tape::Mark mark;
    [[nodiscard]] View view() const {
      return {place.time, place.plane, place.clock_anchor_m, mark.state, mark.covariance};
    }
  };
  /// Calls at_mark(time, smoothed) at each mark, the newest first, where smoothed() is a Smoothed,
  /// until it returns false.
  template <class AtMark>
  void back(SmootherAdjoint<State>& adjoint, const AtMark& at_mark) const {
    bool more = true;
    tape_.back(adjoint, [&](std::size_t i, const typename Tape::Mark& filtered,
                            const SmootherAdjoint<State>& a) {
      const auto smoothed_here = [&] { return Smoothed{places_[i], smoothed<State>(filtered, a)}; };
      more = more && at_mark(places_[i].time, smoothed_here);
    });
  }

  /// The smoothed estimate at the newest mark at or before `wanted`.
  [[nodiscard]] std::optional<GnssInsEstimate> estimate(LogTime wanted,
                                                        const SO3d& q_body_imu) const {
    std::optional<GnssInsEstimate> found;
    SmootherAdjoint<State> adjoint;
    back(adjoint, [&](LogTime time, const auto& smoothed) {
      if (time > wanted) return true;
      found = smoothed().view().estimate(q_body_imu);
      return false;
    });
    return found;
  }

  /// As AnyInsFilter::smooth.
  void smooth(InsAdjoint& adjoint, const SO3d& q_body_imu, const SmoothedSink& sink) const {
    if (!adjoint.has_value()) adjoint = SmootherAdjoint<State>{};
    back(std::any_cast<SmootherAdjoint<State>&>(adjoint), [&](LogTime, const auto& smoothed) {
      const auto now = smoothed();
      sink(now.view().point(q_body_imu), [&] { return now.view().estimate(q_body_imu); });
      return true;
    });
  }

 private:
  std::optional<Duration> kept_;
  Tape tape_;
  std::deque<MarkPlace> places_;
};

}  // namespace wayfare::nav
