#pragma once

#include <wayfare/core/time.hpp>

namespace wayfare {

/// How steps are told from other motion. Found on hands, pockets, arms, necks and bags alike.
struct StepParameters {
  /// The strength is kept between these frequencies, Hz: walking has one to three steps a second.
  double low_hz = 0.8;
  double high_hz = 3.0;
  /// The strength must pass its mean by this part of the swings of late for one swing to be over.
  double pass_part = 0.06;
  /// A step's crest is at least this high, m/s², and this part of the crests of late; its swing,
  /// trough to crest, is at least this part of the swings of late.
  double least_crest = 0.2;
  double crest_part = 0.15;
  double swing_part = 0.35;
  double memory_steps = 15.0;  ///< what "of late" means
  /// No two steps are nearer than this, s, nor nearer than this part of the time between steps of
  /// late.
  double refractory_s = 0.25;
  double refractory_part = 0.5;
  /// Within a walk a time between steps of so many usual ones holds a step that was not seen: an
  /// arm that swings hides every other one at times.
  double hidden_from = 1.75;
  double hidden_to = 2.3;
  /// Steps further apart than this, s, are not of one walk; so many in a row make one.
  double longest_step_s = 1.0;
  int least_steps = 8;
  /// Of these a step that swings less than this part of their median, or further from the next than
  /// this multiple of theirs, is not of the walk.
  double onset_swing_part = 0.3;
  double onset_interval_part = 1.6;
  /// Who walked less than this ago, s, walks again after so many steps.
  double resume_s = 10.0;
  int resume_steps = 3;
  double force_range = 156.0;  ///< a component from here on is cut there, m/s²
};

/// One step, known shortly after its crest.
struct Step {
  LogTime time;           ///< of the crest
  double interval_s;      ///< since the step before; of the first in a walk, to the next
  double crest_mps2;      ///< of the band-limited strength
  double trough_mps2;     ///< lowest since the step before
  double mean_abs_mps2;   ///< mean of the band-limited strength without sign
  double swing_mps2 = 0;  ///< from the trough before the crest to the crest
};

}  // namespace wayfare
