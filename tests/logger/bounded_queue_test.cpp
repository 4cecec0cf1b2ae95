#include <wayfare/logger/detail/bounded_queue.hpp>

#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace wayfare::logger {
namespace {

using std::chrono::milliseconds;

TEST(BoundedQueue, RefusesItemsUntilTakenOnesAreDone) {
  BoundedQueue<int> queue(100);
  EXPECT_TRUE(queue.push(1, 60));
  EXPECT_FALSE(queue.push(2, 41));
  EXPECT_TRUE(queue.push(3, 40));
  queue.push_always(4);
  EXPECT_EQ(queue.take(milliseconds(0)), (std::deque<int>{1, 3, 4}));
  EXPECT_FALSE(queue.push(5, 1)) << "the items taken are still in memory";
  queue.done();
  EXPECT_EQ(queue.cost(), 0U);
  EXPECT_EQ(queue.peak(), 100U);
  EXPECT_TRUE(queue.push(6, 100));
  EXPECT_FALSE(queue.push(7, static_cast<std::size_t>(-1))) << "costs do not overflow";
  EXPECT_EQ(queue.take(milliseconds(0)), std::deque<int>{6});
  EXPECT_TRUE(queue.take(milliseconds(1)).empty());
}

TEST(BoundedQueue, KeepsTheOrderOfEachThreadAndItsCapacity) {
  constexpr int kEach = 20'000;
  BoundedQueue<std::pair<int, int>> queue(64);
  std::vector<std::thread> threads;
  for (int t = 0; t < 3; ++t) {
    threads.emplace_back([&queue, t] {
      for (int i = 0; i < kEach; ++i)
        while (!queue.push({t, i}, 1)) std::this_thread::yield();
    });
  }
  std::vector<int> next(3, 0);
  for (int count = 0; count < 3 * kEach;) {
    for (const auto& [thread, i] : queue.take(milliseconds(100))) {
      EXPECT_EQ(i, next[static_cast<std::size_t>(thread)]++);
      ++count;
    }
    queue.done();
  }
  for (std::thread& t : threads) t.join();
  EXPECT_LE(queue.peak(), 64U);
}

}  // namespace
}  // namespace wayfare::logger
