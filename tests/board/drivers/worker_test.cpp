// A thread that works for one that must not wait. No test waits for a time: each ends when the worker has done what it is asked.
#include "board/drivers/worker.hpp"

#include <gtest/gtest.h>
#include <pthread.h>

#include <atomic>
#include <csignal>
#include <semaphore>
#include <thread>

namespace plenum::board::drivers {
namespace {

TEST(Worker, WorksForItsMakerOnAThreadOfItsOwn) {
  std::binary_semaphore done{0};
  std::thread::id thread;
  Worker worker([&] {
    thread = std::this_thread::get_id();
    done.release();
  });
  worker.wake();
  done.acquire();
  EXPECT_NE(thread, std::this_thread::get_id());
}

TEST(Worker, TakesNoSignal) {
  bool takes_stop = true;
  {
    Worker worker([&] {
      sigset_t blocked;
      ::pthread_sigmask(SIG_BLOCK, nullptr, &blocked);
      takes_stop = ::sigismember(&blocked, SIGTERM) == 0;
    });
    worker.wake();
  }
  EXPECT_FALSE(takes_stop);
  sigset_t blocked;
  ::pthread_sigmask(SIG_BLOCK, nullptr, &blocked);
  EXPECT_EQ(::sigismember(&blocked, SIGTERM), 0) << "its maker still does";
}

TEST(Worker, ItsEndWaitsForWhatIsUnderWay) {
  std::binary_semaphore begun{0};
  std::binary_semaphore go_on{0};
  std::atomic<int> finished{0};
  std::atomic<bool> first{true};
  std::thread helper;
  {
    Worker worker([&] {
      if (first.exchange(false)) {
        begun.release();
        go_on.acquire();
      }
      ++finished;
    });
    worker.wake();
    begun.acquire();
    helper = std::thread([&] { go_on.release(); });
  }
  EXPECT_GE(finished, 1);
  helper.join();
}

}  // namespace
}  // namespace plenum::board::drivers
