#include "search.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>

#include <wayfare/io/text_file.hpp>

namespace wayfare::examples {

void DrivesFitness::operator()(std::span<const double> individuals,
                               std::span<double> scores) const {
  const auto count = static_cast<double>(drives_.size());
  std::vector<double> sum(scores.size(), 0.0);
  for (std::size_t d = 0; d < drives_.size(); ++d) {
    drives_[d](individuals, scores, [&](double f) {
      if (progress) progress((static_cast<double>(d) + f) / count);
    });
    for (std::size_t i = 0; i < scores.size(); ++i) sum[i] += scores[i] / count;
  }
  std::copy(sum.begin(), sum.end(), scores.begin());
}

std::size_t SearchResult::best() const {
  std::size_t best = 0;
  for (std::size_t i = 1; i < runs.size(); ++i)
    if (runs[i].scores.front() < runs[best].scores.front()) best = i;
  return best;
}

std::string checkpoint_name(std::size_t run) {
  char name[40];
  std::snprintf(name, sizeof name, "run_%02zu.checkpoint", run + 1);
  return name;
}

namespace {

Result<std::optional<GeneticState>> read_checkpoint(const std::string& path,
                                                    const GeneticSearch& search,
                                                    const BatchFitness& fitness) {
  if (!std::filesystem::exists(path)) return std::optional<GeneticState>();
  const auto file = io::read_file(path);
  if (!file) return file.error();
  auto state = search.parse(file->bytes, path);
  if (!state) return state.error();
  // Only on the same drives does an individual get the same score.
  const std::vector<double> best = search.best(*state);
  double score = 0.0;
  fitness(best, {&score, 1});
  const double before = state->scores.front();
  if (std::isfinite(before) && !(std::abs(score - before) <= 1e-6 * before))
    return Error{ErrorCode::invalid,
                 "was made on other drives or with other weights: its best scores " +
                     std::to_string(score) + ", not " + std::to_string(before),
                 path};
  return std::optional(*std::move(state));
}

}  // namespace

Result<SearchResult> search(const SearchPlan& plan, const std::vector<Gene>& genes,
                            const GeneticOptions& options, const BatchFitness& fitness,
                            const SearchHooks& hooks) {
  SearchResult result;
  for (std::size_t run = 0; run < plan.runs; ++run) {
    GeneticOptions own = options;
    own.seed += run;
    const GeneticSearch search(genes, own);
    const std::string path = (std::filesystem::path(plan.folder) / checkpoint_name(run)).string();
    std::optional<GeneticState> state;
    if (plan.resume) {
      auto read = read_checkpoint(path, search, fitness);
      if (!read) return read.error();
      state = *std::move(read);
    }
    while (!state || !search.finished(*state)) {
      state = state ? search.next(*state, fitness) : search.start(fitness);
      if (plan.writes) {
        const auto done = io::write_file(path, search.format(*state), {io::Existing::replace});
        if (!done) return done.error();
      }
      if (hooks.after_generation) hooks.after_generation(run, *state);
      const bool last = run + 1 == plan.runs && search.finished(*state);
      if (!last && hooks.stop && hooks.stop()) {
        result.complete = false;
        break;
      }
    }
    result.runs.push_back(*std::move(state));
    result.searches.push_back(search);
    if (!result.complete) break;
  }
  return result;
}

}  // namespace wayfare::examples
