#pragma once

// A step, and the parameters of its detection.

#include <wayfare/core/time.hpp>

namespace wayfare {

/// Parameters of step detection, tuned on hands, pockets, arms, necks and bags alike.
struct StepParameters {
  /// Pass band of the force magnitude, Hz: walking has one to three steps per second.
  double low_hz = 0.8;
  double high_hz = 3.0;  ///< upper end of the pass band
  /// A swing ends when the magnitude passes its mean by this fraction of the recent swings.
  double pass_part = 0.06;
  /// A step's crest is at least this high, m/s², and this fraction of the recent crests; its swing,
  /// trough to crest, is at least this fraction of the recent swings.
  double least_crest = 0.2;
  double crest_part = 0.15;    ///< of the recent crests
  double swing_part = 0.35;    ///< of the recent swings
  double memory_steps = 15.0;  ///< averaging length of "recent"
  /// Smallest interval between steps, s, and as a fraction of the recent intervals.
  double refractory_s = 0.25;
  double refractory_part = 0.5;  ///< of the recent intervals
  /// Within a walk an interval in this range, in recent intervals, contains a missed step: a
  /// swinging arm at times hides every other one.
  double hidden_from = 1.75;
  double hidden_to = 2.3;  ///< of the recent intervals
  /// Longest interval within a walk, s, and the number of consecutive steps that start one.
  double longest_step_s = 1.0;
  int least_steps = 8;  ///< in a row that start a walk
  /// Of these, a step with a swing below this fraction of their median, or an interval to the next
  /// above this multiple of theirs, does not belong to the walk.
  double onset_swing_part = 0.3;
  double onset_interval_part = 1.6;  ///< of their median interval
  /// Within this time after a walk, s, it resumes after this number of steps.
  double resume_s = 10.0;
  int resume_steps = 3;        ///< in a row that resume a walk
  double force_range = 156.0;  ///< components are clipped at this magnitude, m/s²
};

/// One step, detected shortly after its crest.
struct Step {
  LogTime time;           ///< of the crest
  double interval_s;      ///< since the previous step; of the first in a walk, to the next
  double crest_mps2;      ///< of the band-passed magnitude
  double trough_mps2;     ///< lowest since the previous step
  double mean_abs_mps2;   ///< mean absolute band-passed magnitude
  double swing_mps2 = 0;  ///< from the preceding trough to the crest
};

}  // namespace wayfare
