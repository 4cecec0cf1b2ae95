#include <wayfare/tune/genetic.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numeric>

#include <wayfare/core/contract.hpp>
#include <wayfare/core/random.hpp>

namespace wayfare {

double Gene::value(double unit) const {
  if (logarithmic) return std::min(high, std::max(low, low * std::pow(high / low, unit)));
  return low + unit * (high - low);
}

double Gene::unit(double value) const {
  if (!(high > low)) return 0.0;
  const double u = logarithmic ? std::log(std::max(value, low) / low) / std::log(high / low)
                               : (value - low) / (high - low);
  return std::clamp(u, 0.0, 1.0);
}

GeneticSearch::GeneticSearch(std::vector<Gene> genes, const GeneticOptions& options)
    : genes_(std::move(genes)), options_(options) {
  WAYFARE_EXPECTS(!genes_.empty() && options.population >= 2,
                  "at least one gene and two individuals");
  WAYFARE_EXPECTS(options.elite < options.population, "the elite is smaller than the population");
  for (const Gene& g : genes_)
    WAYFARE_EXPECTS(g.low <= g.high && std::isfinite(g.high - g.low) &&
                        (!g.logarithmic || (g.low > 0.0 && std::isfinite(g.high / g.low))),
                    "ordered bounds of finite range, positive for logarithmic genes");
}

GeneticState GeneticSearch::start(const BatchFitness& fitness,
                                  std::span<const double> known) const {
  const std::size_t n = genes_.size(), rows = known.size() / n;
  Rng rng = Rng(options_.seed).stream(0);
  GeneticState state;
  state.units.reserve(options_.population * n);
  for (std::size_t i = 0; i < options_.population; ++i)
    for (std::size_t g = 0; g < n; ++g) {
      const double random = rng.uniform();
      const bool is_known = i < rows && !std::isnan(known[i * n + g]);
      state.units.push_back(is_known ? genes_[g].unit(known[i * n + g]) : random);
    }
  state.scores.assign(options_.population, 0.0);
  evaluate(state, 0, 0, fitness);
  return state;
}

namespace {

/// Tournament (Goldberg and Deb 1991), or linear ranking (Baker 1985): the k-th best of n is
/// selected with probability (p − (2p − 2) k/(n − 1))/n.
class ParentDraw {
 public:
  explicit ParentDraw(const GeneticOptions& o) : n_(o.population), tournament_(o.tournament) {
    if (tournament_ == 0) rank(o.population, o.selection_pressure);
  }
  /// The index of a parent, the best individual being the first.
  [[nodiscard]] std::size_t operator()(Rng& rng) const {
    return tournament_ == 0 ? by_rank(rng) : by_tournament(rng);
  }

 private:
  void rank(std::size_t n, double pressure) {
    double sum = 0.0;
    for (std::size_t k = 0; k < n; ++k) {
      sum +=
          pressure - (2.0 * pressure - 2.0) * static_cast<double>(k) / static_cast<double>(n - 1);
      cumulative_.push_back(sum);
    }
  }
  [[nodiscard]] std::size_t by_rank(Rng& rng) const {
    const double at = rng.uniform(0.0, cumulative_.back());
    const auto it = std::upper_bound(cumulative_.begin(), cumulative_.end(), at);
    return std::min(static_cast<std::size_t>(it - cumulative_.begin()), cumulative_.size() - 1);
  }
  [[nodiscard]] std::size_t by_tournament(Rng& rng) const {
    std::size_t best = n_ - 1;
    for (std::size_t i = 0; i < tournament_; ++i) best = std::min<std::size_t>(best, rng.below(n_));
    return best;
  }

  std::size_t n_, tournament_;
  std::vector<double> cumulative_;
};

}  // namespace

GeneticState GeneticSearch::next(const GeneticState& state, const BatchFitness& fitness) const {
  const std::size_t n = genes_.size();
  WAYFARE_EXPECTS(state.units.size() == options_.population * n &&
                      state.scores.size() == options_.population && !state.history.empty(),
                  "the state is of this search");
  Rng rng = Rng(options_.seed).stream(state.generation());
  const ParentDraw draw(options_);
  const double done = static_cast<double>(state.generation()) /
                      static_cast<double>(std::max<std::size_t>(1, options_.generations));
  const double sigma = options_.mutation_sigma * std::max(0.1, 1.0 - done);
  GeneticState child = state;
  child.units.resize(options_.elite * n);
  for (std::size_t i = options_.elite; i < options_.population; ++i) {
    const double* mother = &state.units[draw(rng) * n];
    const double* father = &state.units[draw(rng) * n];
    std::size_t a = rng.below(n + 1), b = rng.below(n + 1);
    if (a > b) std::swap(a, b);
    if (!(rng.uniform() < options_.crossover_rate)) a = b = 0;
    for (std::size_t g = 0; g < n; ++g) {
      double u = g >= a && g < b ? father[g] : mother[g];
      if (rng.uniform() < options_.mutation_rate)
        u = std::clamp(u + sigma * rng.normal(), 0.0, 1.0);
      child.units.push_back(u);
    }
  }
  evaluate(child, options_.elite, state.history.back().evaluations, fitness);
  return child;
}

void GeneticSearch::evaluate(GeneticState& state, std::size_t from, std::size_t evaluations,
                             const BatchFitness& fitness) const {
  const std::size_t n = genes_.size(), all = options_.population;
  std::vector<double> values;
  values.reserve((all - from) * n);
  for (std::size_t i = from; i < all; ++i)
    for (std::size_t g = 0; g < n; ++g) values.push_back(genes_[g].value(state.units[i * n + g]));
  fitness(values, std::span(state.scores).subspan(from));
  for (double& s : state.scores)
    if (!std::isfinite(s)) s = std::numeric_limits<double>::infinity();

  std::vector<std::size_t> order(all);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&state](std::size_t a, std::size_t b) {
    return state.scores[a] < state.scores[b];
  });
  GeneticState sorted;
  sorted.history = std::move(state.history);
  GenerationSummary summary;
  for (const std::size_t i : order) {
    const auto row = state.units.begin() + static_cast<std::ptrdiff_t>(i * n);
    sorted.units.insert(sorted.units.end(), row, row + static_cast<std::ptrdiff_t>(n));
    sorted.scores.push_back(state.scores[i]);
    if (std::isfinite(state.scores[i])) {
      summary.mean += state.scores[i];
    } else {
      ++summary.failed;
    }
  }
  summary.mean /= static_cast<double>(std::max<std::size_t>(1, all - summary.failed));
  summary.best = sorted.scores.front();
  summary.evaluations = evaluations + all - from;
  sorted.history.push_back(summary);
  state = std::move(sorted);
}

std::vector<double> GeneticSearch::best(const GeneticState& state) const {
  WAYFARE_EXPECTS(state.units.size() >= genes_.size(), "the state is of this search");
  std::vector<double> values;
  for (std::size_t g = 0; g < genes_.size(); ++g) values.push_back(genes_[g].value(state.units[g]));
  return values;
}

namespace {

/// The shortest text that is read back as the same number.
std::string text_of(double v) {
  char digits[64];
  return {digits, std::to_chars(digits, digits + sizeof digits, v).ptr};
}

/// Sequential tokens of a text.
class Words {
 public:
  Words(std::string_view text, const std::string& source) : text_(text), source_(source) {}

  template <class T>
  [[nodiscard]] bool number(T& v) {
    skip();
    const auto end = std::from_chars(text_.data() + at_, text_.data() + text_.size(), v);
    if (end.ec != std::errc()) return false;
    at_ = static_cast<std::size_t>(end.ptr - text_.data());
    return true;
  }
  [[nodiscard]] bool expect(std::string_view word) {
    skip();
    if (!text_.substr(at_).starts_with(word)) return false;
    at_ += word.size();
    return true;
  }
  [[nodiscard]] Error fault(const std::string& what) const {
    return {ErrorCode::parse, what, source_, 0, at_};
  }

 private:
  void skip() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\n')) ++at_;
  }
  std::string_view text_;
  std::string source_;
  std::size_t at_ = 0;
};

}  // namespace

std::string GeneticSearch::header() const {
  std::string text = "genetic-search-1\nseed " + std::to_string(options_.seed) + "\npopulation " +
                     std::to_string(options_.population) + "\nelite " +
                     std::to_string(options_.elite) + "\nhow ";
  for (const double v : {static_cast<double>(options_.generations), options_.selection_pressure,
                         options_.crossover_rate, options_.mutation_rate, options_.mutation_sigma})
    text += text_of(v) + ' ';
  if (options_.tournament > 0) text += "tournament " + std::to_string(options_.tournament);
  text += "\n";
  for (const Gene& g : genes_)
    text += "gene " + g.name + (g.logarithmic ? " log " : " linear ") + text_of(g.low) + ' ' +
            text_of(g.high) + '\n';
  return text;
}

std::string GeneticSearch::format(const GeneticState& state) const {
  std::string text = header() + "generations " + std::to_string(state.history.size()) + "\n";
  for (const GenerationSummary& s : state.history)
    text += text_of(s.best) + ' ' + text_of(s.mean) + ' ' + std::to_string(s.failed) + ' ' +
            std::to_string(s.evaluations) + '\n';
  text += "individuals\n";
  for (std::size_t i = 0; i < state.scores.size(); ++i) {
    text += text_of(state.scores[i]);
    for (std::size_t g = 0; g < genes_.size(); ++g)
      text += ' ' + text_of(state.units[i * genes_.size() + g]);
    text += '\n';
  }
  return text + "end\n";
}

Result<GeneticState> GeneticSearch::parse(std::string_view text, const std::string& source) const {
  const std::string expected = header();
  if (!text.starts_with(expected))
    return Error{ErrorCode::invalid,
                 "is of another search: genes, bounds, seed and options must be unchanged", source};
  Words words(text.substr(expected.size()), source);
  GeneticState state;
  std::size_t generations = 0;
  if (!words.expect("generations") || !words.number(generations) || generations == 0 ||
      generations > 1'000'000)
    return words.fault("expected the number of generations");
  for (std::size_t i = 0; i < generations; ++i) {
    GenerationSummary s;
    if (!words.number(s.best) || !words.number(s.mean) || !words.number(s.failed) ||
        !words.number(s.evaluations))
      return words.fault("expected best, mean, failed and evaluations of a generation");
    state.history.push_back(s);
  }
  if (!words.expect("individuals")) return words.fault("expected the individuals");
  for (std::size_t i = 0; i < options_.population; ++i) {
    double v = 0.0;
    if (!words.number(v)) return words.fault("expected a score");
    state.scores.push_back(v);
    for (std::size_t g = 0; g < genes_.size(); ++g) {
      if (!words.number(v) || !(v >= 0.0) || !(v <= 1.0))
        return words.fault("expected a gene in [0, 1]");
      state.units.push_back(v);
    }
  }
  if (!words.expect("end")) return words.fault("is truncated");
  if (!std::is_sorted(state.scores.begin(), state.scores.end()) ||
      std::any_of(state.scores.begin(), state.scores.end(), [](double s) { return std::isnan(s); }))
    return words.fault("the individuals are not in order of their scores");
  if (format(state) != text) return words.fault("is not as it was written");
  return state;
}

}  // namespace wayfare
