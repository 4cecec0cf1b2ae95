#include "failing_allocations.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <new>

namespace wayfare::tests {

std::atomic<long> failing_in{-1}, failing_every{0}, allocations{0};

namespace {

bool fails() {
  allocations.fetch_add(1, std::memory_order_relaxed);
  if (failing_in.load(std::memory_order_relaxed) < 0) return false;
  if (failing_in.fetch_sub(1, std::memory_order_relaxed) != 0) return false;
  failing_in.store(failing_every.load() > 0 ? failing_every.load() - 1 : -1);
  return true;
}

}  // namespace

}  // namespace wayfare::tests

// Eigen's matrices come from malloc: the linker gives calls of our objects to __wrap_malloc.
// NOLINTBEGIN(bugprone-reserved-identifier,cppcoreguidelines-no-malloc): the linker's names, and
// what is replaced
extern "C" void* __real_malloc(std::size_t size);

namespace {

void* allocated(std::size_t size, std::size_t alignment = alignof(std::max_align_t)) {
  void* memory = nullptr;
  if (!wayfare::tests::fails())
    memory = alignment <= alignof(std::max_align_t)
                 ? __real_malloc(std::max<std::size_t>(size, 1))
                 : std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

void* operator new(std::size_t size) { return allocated(size); }
void* operator new[](std::size_t size) { return allocated(size); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocated(size, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return allocated(size, static_cast<std::size_t>(alignment));
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return wayfare::tests::fails() ? nullptr : __real_malloc(std::max<std::size_t>(size, 1));
}
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
  return wayfare::tests::fails() ? nullptr : __real_malloc(std::max<std::size_t>(size, 1));
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

extern "C" void* __wrap_malloc(std::size_t size) {
  return wayfare::tests::fails() ? nullptr : __real_malloc(size);
}
// NOLINTEND(bugprone-reserved-identifier,cppcoreguidelines-no-malloc)
