#pragma once

// Snapshots of one Awinda station in the order they were taken, and the motion between them.

#include <array>
#include <cstddef>
#include <cstdint>

#include <wayfare/decode/awinda.hpp>

namespace wayfare::decode {

/// Puts one tracker's snapshots into the order of their frames. A missing one is waited for until
/// one `kWindow` frames later is there; then it is given up.
template <std::size_t kWindow = 32>
class AwindaOrder {
 public:
  template <class Sink>
  void add(const AwindaSnapshot& snapshot, Sink&& sink) {
    if (!begun_) {
      begun_ = true;
      next_ = snapshot.frame;
    }
    const auto ahead = static_cast<std::int32_t>(snapshot.frame - next_);  // comes round with it
    if (ahead < 0 || held(snapshot.frame)) {
      ++late_;
      return;
    }
    // A jump of more than twice the window is another recording: what is held is all there is.
    if (static_cast<std::size_t>(ahead) >= 2 * kWindow) {
      finish(sink);
      begun_ = true;
      next_ = snapshot.frame;
    }
    while (snapshot.frame - next_ >= kWindow) step(sink);
    slots_[snapshot.frame % kWindow] = {snapshot, true};
    while (slots_[next_ % kWindow].full) step(sink);
  }

  /// What is still waiting for missing ones.
  template <class Sink>
  void finish(Sink&& sink) {
    for (std::size_t i = 0; i < kWindow && begun_; ++i) {
      Slot& slot = slots_[(next_ + i) % kWindow];
      if (slot.full) sink(static_cast<const AwindaSnapshot&>(slot.snapshot));
      slot.full = false;
    }
    begun_ = false;
  }

  [[nodiscard]] std::uint64_t late() const { return late_; }  ///< too late, or twice: not given
  [[nodiscard]] std::uint64_t missing() const { return missing_; }  ///< given up

 private:
  struct Slot {
    AwindaSnapshot snapshot;
    bool full = false;
  };
  static_assert((kWindow & (kWindow - 1)) == 0, "frames come round at a power of two");

  [[nodiscard]] bool held(std::uint32_t frame) const {
    const Slot& slot = slots_[frame % kWindow];
    return slot.full && slot.snapshot.frame == frame;
  }
  template <class Sink>
  void step(Sink& sink) {
    Slot& slot = slots_[next_ % kWindow];
    if (slot.full) {
      sink(static_cast<const AwindaSnapshot&>(slot.snapshot));
    } else {
      ++missing_;
    }
    slot.full = false;
    ++next_;
  }

  std::array<Slot, kWindow> slots_{};
  std::uint32_t next_ = 0;
  bool begun_ = false;
  std::uint64_t late_ = 0, missing_ = 0;
};

/// The trackers of a station: snapshots in as they come, motions out, each tracker's in order.
template <std::size_t kTrackers = 32, std::size_t kWindow = 32>
class AwindaStation {
 public:
  /// `period_s`: of a frame, the station's output rate.
  explicit AwindaStation(double period_s) : period_s_(period_s) {}

  /// Calls `sink(const AwindaMotion&)`.
  template <class Sink>
  void add(const AwindaSnapshot& snapshot, Sink&& sink) {
    Tracker* tracker = find(snapshot.device);
    if (tracker == nullptr) {
      ++refused_;
      return;
    }
    tracker->order.add(snapshot, [&](const AwindaSnapshot& s) { follow(*tracker, s, sink); });
  }
  template <class Sink>
  void finish(Sink&& sink) {
    for (std::size_t i = 0; i < trackers_; ++i) {
      Tracker& tracker = all_[i];
      tracker.order.finish([&](const AwindaSnapshot& s) { follow(tracker, s, sink); });
      tracker.has_before = false;
    }
  }

  [[nodiscard]] std::size_t trackers() const { return trackers_; }
  /// Snapshots of trackers there was no room for.
  [[nodiscard]] std::uint64_t refused() const { return refused_; }
  [[nodiscard]] std::uint64_t late() const {
    std::uint64_t sum = 0;
    for (const Tracker& tracker : all_) sum += tracker.order.late();
    return sum;
  }
  [[nodiscard]] std::uint64_t missing() const {
    std::uint64_t sum = 0;
    for (const Tracker& tracker : all_) sum += tracker.order.missing();
    return sum;
  }

 private:
  struct Tracker {
    std::uint32_t device = 0;
    bool has_before = false;
    AwindaSnapshot before;
    AwindaOrder<kWindow> order;
  };

  Tracker* find(std::uint32_t device) {
    for (std::size_t i = 0; i < trackers_; ++i)
      if (all_[i].device == device) return &all_[i];
    if (trackers_ == kTrackers) return nullptr;
    all_[trackers_].device = device;
    return &all_[trackers_++];
  }
  template <class Sink>
  void follow(Tracker& tracker, const AwindaSnapshot& s, Sink& sink) {
    if (tracker.has_before) sink(awinda_motion(tracker.before, s, period_s_));
    tracker.before = s;
    tracker.has_before = true;
  }

  double period_s_;
  std::array<Tracker, kTrackers> all_{};
  std::size_t trackers_ = 0;
  std::uint64_t refused_ = 0;
};

}  // namespace wayfare::decode
