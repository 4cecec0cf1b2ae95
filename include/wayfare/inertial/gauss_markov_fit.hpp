#pragma once

// A first-order Gauss-Markov process found in a long record by its autocorrelation (Gelb 1974,
// section 2.5).

#include <cstddef>
#include <vector>

namespace wayfare {

/// R(t) = σ² e^(−t/τ) of what is slow in a record; `found` is false where its autocorrelation does
/// not fall off within the record.
struct GaussMarkovFit {
  bool found = false;
  double sigma = 0.0, tau_s = 0.0;
  /// Standard deviations, by how the lags of such a process scatter (Bartlett 1946).
  double sigma_sigma = 0.0, tau_sigma_s = 0.0;
};

/// Takes readings one by one; keeps means of blocks that double in length as the record grows.
class AutocorrelationRecorder {
 public:
  /// `period_s` between readings, which are evenly spaced; at most `blocks` means are kept.
  explicit AutocorrelationRecorder(double period_s, std::size_t blocks = 32768);

  /// A value that is not finite is left out.
  void add(double value);

  /// Of the block means about their own mean, one each block_s().
  [[nodiscard]] std::vector<double> autocorrelation(std::size_t lags) const;
  [[nodiscard]] double block_s() const { return period_s_ * static_cast<double>(length_); }

  /// Generalised least squares on the lags after the first (white noise lives at lag zero alone) up
  /// to where the correlation has fallen to a quarter. That the record's own mean is taken off,
  /// which lowers every lag, is part of the model.
  [[nodiscard]] GaussMarkovFit fit() const;

 private:
  void close_block();

  double period_s_;
  std::size_t most_;
  std::size_t length_ = 1;  ///< readings a block
  std::size_t in_block_ = 0;
  double first_ = 0.0, block_sum_ = 0.0;
  bool started_ = false;
  std::vector<double> means_;
};

}  // namespace wayfare
