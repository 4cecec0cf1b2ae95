#include "ranks.hpp"

#include <cstdlib>
#include <utility>
#include <vector>

#ifdef WAYFARE_MPI
#include <mpi.h>
#endif

namespace wayfare::examples {

#ifdef WAYFARE_MPI

Ranks::Ranks(int* argc, char*** argv) {
  // Without a launcher, MPI need not be initialised.
  const bool launched =
      std::getenv("OMPI_COMM_WORLD_SIZE") || std::getenv("PMI_SIZE") || std::getenv("PMIX_RANK");
  if (!launched) return;
  MPI_Init(argc, argv);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &count_);
}

Ranks::~Ranks() {
  int running = 0;
  MPI_Initialized(&running);
  if (running != 0) MPI_Finalize();
}

BatchFitness Ranks::share(BatchFitness fitness) const {
  if (count_ == 1) return fitness;
  return [fitness = std::move(fitness), rank = rank_, count = count_](auto x, auto scores) {
    const std::size_t n = scores.size(), genes = n == 0 ? 0 : x.size() / n;
    const auto begin = [n, count](int r) {
      return n * static_cast<std::size_t>(r) / static_cast<std::size_t>(count);
    };
    std::vector<int> sizes, starts;
    for (int r = 0; r < count; ++r) {
      starts.push_back(static_cast<int>(begin(r)));
      sizes.push_back(static_cast<int>(begin(r + 1) - begin(r)));
    }
    const std::size_t from = begin(rank), mine = begin(rank + 1) - from;
    std::vector<double> own(mine);
    if (mine > 0) fitness(x.subspan(from * genes, mine * genes), own);
    MPI_Allgatherv(own.data(), static_cast<int>(mine), MPI_DOUBLE, scores.data(), sizes.data(),
                   starts.data(), MPI_DOUBLE, MPI_COMM_WORLD);
  };
}

bool Ranks::any(bool mine) const {
  if (count_ == 1) return mine;
  int in = mine ? 1 : 0, out = 0;
  MPI_Allreduce(&in, &out, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  return out != 0;
}

void Ranks::abort(int code) const {
  if (count_ > 1) MPI_Abort(MPI_COMM_WORLD, code);
}

#else

Ranks::Ranks(int*, char***) {}
Ranks::~Ranks() = default;
BatchFitness Ranks::share(BatchFitness fitness) const { return fitness; }
bool Ranks::any(bool mine) const { return mine; }
void Ranks::abort(int) const {}

#endif

}  // namespace wayfare::examples
