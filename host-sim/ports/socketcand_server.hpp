// A simulated bus, open to other programs by the protocol of socketcand (host-sim/wire/socketcand.hpp).
//
// Each client that has opened the channel is a node of its own: its frames arbitrate with those of the boards, take their
// time on the wire, and reach the boards and the other clients. Nothing here blocks but wait(). A client that writes faster
// than the bus carries is read no further until the bus has room, so that no frame of it is lost; one that does not read
// is dropped, so that nothing of the others is.
//
// Served: open; rawmode; bcmmode with subscribe, filter (whose intervals are taken as 0), unsubscribe, and the cyclic jobs add, update
// and delete; controlmode with statistics; send, echo. Not served: ISO-TP, and the beacon, which is broadcast in the network.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host-sim/ports/simulated_bus.hpp"
#include "host-sim/wire/file_descriptor.hpp"
#include "host-sim/wire/socketcand.hpp"

namespace plenum::host::ports {

class SocketcandServer {
 public:
  struct Counters {
    unsigned clients = 0;             ///< that have opened the channel
    unsigned dropped = 0;             ///< of them: read too slowly, or wrote what is no socketcand
    std::uint64_t frames_taken = 0;   ///< from clients
    std::uint64_t frames_handed = 0;  ///< to clients, each counted
  };

  /// Listens on `host`:`port`; port 0 is any free one. `tell` gets a line for each client that comes, goes or is dropped.
  /// The bus must outlive the server. Throws std::runtime_error: what, where, what was expected.
  SocketcandServer(SimulatedBus& bus, const std::string& host, std::uint16_t port, std::string channel,
                   std::function<void(const std::string&)> tell);

  std::uint16_t port() const { return port_; }
  const Counters& counters() const { return counters_; }

  /// Until there is something to exchange, at most `seconds`; earlier when a signal comes.
  void wait(double seconds) const;
  /// Takes connections, writes what waits for the clients, and queues what they have sent, as of now on the bus.
  void exchange();
  /// Takes what the bus has delivered to the clients. To be called after each delivery, whose time it is: `time_us` stands
  /// in the messages.
  void collect(std::uint64_t time_us);

  static constexpr std::size_t kClients = 32;
  static constexpr std::size_t kUnsentBytes = 1 << 18;  ///< beyond the socket's own buffer
  static constexpr std::size_t kJobs = 64;              ///< of a client

 private:
  enum class Mode { no_bus, broadcast_manager, raw, control };
  using Key = std::pair<bool, std::uint32_t>;  ///< extended, identifier

  struct Subscription {
    std::optional<CanFrame> mask{};   ///< of the content that counts; empty: every frame
    std::optional<CanFrame> last{};   ///< handed on, or to be
    std::uint64_t every_ns = 0;       ///< between two at least
    std::uint64_t due_ns = 0;         ///< of the bus: not before it
    std::optional<CanFrame> early{};  ///< the newest that came before
  };
  struct Job {
    CanFrame frame;
    std::uint64_t every_ns = 0;
    std::uint64_t due_ns = 0;  ///< of the bus
  };
  struct Traffic {
    std::uint64_t bytes = 0, frames = 0;
    void add(const CanFrame& frame) {
      bytes += frame.length;
      ++frames;
    }
  };

  struct Client {
    wire::FileDescriptor socket;
    unsigned number = 0;
    Mode mode = Mode::no_bus;
    SimulatedCanPort* port = nullptr;
    std::map<Key, Subscription> subscribed;
    std::map<Key, Job> jobs;
    Traffic received, sent;
    std::uint64_t statistics_ns = 0;      ///< between two messages; 0: none
    std::uint64_t statistics_due_ns = 0;  ///< of the bus
    wire::MessageReader reader;
    std::string unsent;
    std::string kept_back;  ///< frames of the time until `quiet_until`, or until it says something
    std::chrono::steady_clock::time_point quiet_until{};
    std::optional<CanFrame> held;  ///< waits for room in the port's queue
    std::string leaving;           ///< why it goes, as soon as the bus has what it sent; empty: it stays
  };

  void accept_clients();
  void read(Client& client);
  void handle_messages(Client& client);
  void handle(Client& client, const std::string& message);
  bool handle_broadcast(Client& client, std::span<const std::string_view> words);
  bool handle_control(Client& client, std::span<const std::string_view> words);
  void end_quiet(Client& client);
  void do_what_is_due(Client& client);
  bool wants(Client& client, const CanFrame& frame);
  void hand_on(Client& client, const CanFrame& frame, std::uint64_t time_us);
  void open(Client& client, std::string_view channel);
  void write(Client& client);
  void leave(Client& client);
  void drop(Client& client, const std::string& why);

  SimulatedBus& bus_;
  wire::FileDescriptor listening_;
  std::uint16_t port_;
  std::string channel_;
  std::function<void(const std::string&)> tell_;
  std::list<Client> clients_;
  std::vector<SimulatedCanPort*> free_ports_;  ///< of clients that have gone
  unsigned connections_ = 0;
  Counters counters_;
  std::uint64_t epoch_us_ = 0;  ///< of the times handed on, when the bus began
};

}  // namespace plenum::host::ports
