// Several masters on one simulated bus, each a thread, of which one runs at a time: whoever has something to take. Nobody's turn
// depends on the machine, so that the same masters give the same frames.
#pragma once

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "tests/client/board_on_bus.hpp"

namespace plenum::host::client {

class Masters {
 public:
  explicit Masters(BoardOnBus& world) : world_(world) {}

  /// One that begins at `begin_s` and does `work` over a link of its own. To be called before run().
  void add(double begin_s, std::function<void(Link&)> work) {
    masters_.emplace_back(*this, masters_.size(), ns(begin_s), std::move(work));
  }

  /// Until all have ended. An exception of a master's work is the caller's, at the end.
  void run() {
    std::vector<std::thread> threads;
    for (Master& master : masters_) {
      threads.emplace_back([this, &master] {
        master.sleep_until(master.begin_ns);
        try {
          master.work(master);
        } catch (...) {
          failed_ = std::current_exception();
        }
        master.ended = true;
        std::unique_lock lock(mutex_);
        give_turn(lock);
      });
    }
    for (std::thread& thread : threads) thread.join();
    if (failed_) std::rethrow_exception(failed_);
  }

 private:
  class Master final : public Link {
   public:
    Master(Masters& all, std::size_t number, std::uint64_t begin, std::function<void(Link&)> does)
        : begin_ns(begin),
          work(std::move(does)),
          all_(all),
          number_(number),
          port_(all.world_.bus.attach("master")) {}

    void send(const CanFrame& frame) override {
      while (!port_.send(frame)) sleep_until(all_.world_.bus.now_ns() + 100'000);
    }
    std::optional<CanFrame> receive(double timeout_s) override {
      wait_until(all_.world_.bus.now_ns() + ns(timeout_s));
      return std::exchange(arrived_, std::nullopt);
    }
    double now_s() const override { return all_.world_.now_s(); }

    /// Lets the others and the world go on until then; what comes meanwhile stays where it is.
    void sleep_until(std::uint64_t until) {
      takes_ = false;
      wait_until(until);
      takes_ = true;
    }
    /// Lets the others and the world go on until a frame or `until` has come.
    void wait_until(std::uint64_t until) {
      std::unique_lock lock(all_.mutex_);
      until_ns = until;
      while (all_.turn_ != number_ || !is_ready()) {
        if (all_.turn_ == number_) all_.give_turn(lock);
        all_.changed_.wait(lock, [&] { return all_.turn_ == number_; });
      }
    }
    bool is_ready() {
      CanFrame frame;
      if (!takes_) return all_.world_.bus.now_ns() >= until_ns;
      if (!arrived_ && port_.receive(frame)) arrived_ = frame;
      return arrived_.has_value() || all_.world_.bus.now_ns() >= until_ns;
    }

    std::uint64_t begin_ns;
    std::function<void(Link&)> work;
    std::uint64_t until_ns = 0;
    bool ended = false;
    bool takes_ = true;

   private:
    Masters& all_;
    std::size_t number_;
    ports::SimulatedCanPort& port_;
    std::optional<CanFrame> arrived_;
  };

  static std::uint64_t ns(double seconds) {
    return static_cast<std::uint64_t>(std::llround(seconds * 1.0e9));
  }

  /// To the next one that is ready; when nobody is, the world goes on.
  void give_turn(std::unique_lock<std::mutex>&) {
    while (true) {
      std::uint64_t next_ns = UINT64_MAX;
      for (std::size_t k = 1; k <= masters_.size(); ++k) {
        Master& master = masters_[(turn_ + k) % masters_.size()];
        if (master.ended) continue;
        if (master.is_ready()) {
          turn_ = (turn_ + k) % masters_.size();
          return changed_.notify_all();
        }
        next_ns = std::min(next_ns, master.until_ns);
      }
      if (next_ns == UINT64_MAX) return;  // all have ended
      world_.advance(next_ns);
    }
  }

  BoardOnBus& world_;
  std::deque<Master> masters_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t turn_ = 0;
  std::exception_ptr failed_;
};

}  // namespace plenum::host::client
