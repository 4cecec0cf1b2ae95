#include <wayfare/graph/multifrontal_cholesky.hpp>

#include <optional>

#include <wayfare/core/contract.hpp>

#include "graph/cholesky/factor.hpp"

namespace wayfare {

struct MultifrontalFactor::State {
  std::optional<cholesky::Factor> factor;
  int threads = 1;
};

MultifrontalFactor::MultifrontalFactor() : state_(std::make_unique<State>()) {}
MultifrontalFactor::MultifrontalFactor(MultifrontalFactor&&) noexcept = default;
MultifrontalFactor& MultifrontalFactor::operator=(MultifrontalFactor&&) noexcept = default;
MultifrontalFactor::~MultifrontalFactor() = default;

void MultifrontalFactor::analyse(std::span<const int> starts, std::span<const int> rows, int block,
                                 int leading) {
  const cholesky::UpperPattern pattern{starts, rows};
  state_->factor.emplace(cholesky::plan_fronts(pattern, cholesky::minimum_degree(pattern), block),
                         leading);
}

void MultifrontalFactor::set_threads(int threads) {
  WAYFARE_EXPECTS(threads > 0, "the number of threads must be positive");
  state_->threads = threads;
}

FactorOutcome MultifrontalFactor::factorise(const double* values) {
  WAYFARE_EXPECTS(state_->factor, "analyse() must be called before factorise()");
  return state_->factor->judge(values, state_->factor->factorise(values, state_->threads));
}

void MultifrontalFactor::solve_in_place(double* x) { state_->factor->solve_in_place(x); }

void MultifrontalFactor::invert() { state_->factor->invert(); }

bool MultifrontalFactor::inverse_block(int row, int column, double* out) const {
  return state_->factor && state_->factor->inverse_block(row, column, out);
}

}  // namespace wayfare
