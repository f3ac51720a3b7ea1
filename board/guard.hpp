// The guard of the valves: a second process, which makes the outputs safe when the loop's own cannot any more.
//
//     loop    outputs opened, fork, the other devices, tick: beat(), tick: beat(), ...
//     guard                   +-- sleeps -- the loop has ended:  outputs safe
//                                        \- no beat for so long:  kills it, outputs safe, and again when it has ended
//
// It has by inheritance what it needs and nothing else: lines and attributes of the outputs, open. A line of a GPIO chip is
// its requester's alone, so a program that opened its own could not have them; and while the guard holds them the kernel does
// not let the lines go.
//
// The two share a timer of the kernel. A beat puts it off: a system call of the loop's, which wakes nobody. An answer that
// the guard has to give at each tick would be two changes of process in it. The end of the silence is slept through once more:
// whatever kept the guard and the loop from the processor alike lets the loop tick first.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string_view>

namespace plenum::board {

/// What a guard sees, and what it can do.
class GuardPost {
 public:
  enum class Seen : std::uint8_t { end, silence };

  /// Sleeps until the loop's thread has ended, or has been silent for too long.
  virtual Seen watch() noexcept = 0;
  virtual void kill() noexcept = 0;
  virtual void wait_for_end() noexcept = 0;
  virtual void make_safe() noexcept = 0;
  virtual void report(std::string_view line) noexcept = 0;

 protected:
  ~GuardPost() = default;
};

/// The duty of a guard, once. A silent loop is killed first: what it may still write until it has ended is written over.
void stand_guard(GuardPost& post) noexcept;

/// The outputs, for which the guard stands.
class SafeOutputs {
 public:
  /// Is called in the guard's process, too: it may take no lock and no memory.
  virtual void make_safe() noexcept = 0;

 protected:
  ~SafeOutputs() = default;
};

/// The loop's end of it.
class Guard {
 public:
  /// The last part of a silence, in which the guard is awake: more than a tick takes.
  static constexpr int kGrace_ms = 20;

  struct Config {
    std::uint64_t silence_ns;  ///< between two beats, and no longer; more than twice the grace
    int priority;              ///< of SCHED_FIFO, above that of the loop; 0: the ordinary scheduler
  };

  /// Forks, and returns when the guard stands. By the thread that will be the loop's, while the process has no other and has
  /// nothing open that is not the guard's affair. `outputs` must outlive it. Throws std::runtime_error.
  Guard(const Config& config, SafeOutputs& outputs);
  /// Ends the guard, which does nothing more.
  ~Guard();
  Guard(const Guard&) = delete;
  Guard& operator=(const Guard&) = delete;

  /// A tick has been done. From the first one on the guard minds silence.
  void beat() noexcept;
  /// The outputs are safe, and there is no tick for a while: silence means nothing until the next beat.
  void rest() noexcept;
  /// False: it has ended, or was stopped. SIGCHLD tells when to ask.
  bool stands() const noexcept;

 private:
  /// False: errno says why.
  bool post(int priority, SafeOutputs& outputs);
  void dismiss() noexcept;
  void set_timer(std::uint64_t time_ns) noexcept;

  std::uint64_t silence_ns_;
  int loop_ = -1;   ///< this process, as a descriptor
  int timer_ = -1;  ///< of the silence
  pid_t guard_ = -1;
};

}  // namespace plenum::board
