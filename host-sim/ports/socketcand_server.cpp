#include "host-sim/ports/socketcand_server.hpp"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <utility>

#include "host-sim/wire/tcp.hpp"

namespace plenum::host::ports {

SocketcandServer::SocketcandServer(SimulatedBus& bus, const std::string& host, std::uint16_t port,
                                   std::string channel, std::function<void(const std::string&)> tell)
    : bus_(bus),
      listening_(wire::listen_tcp(host, port)),
      port_(wire::port_of(listening_)),
      channel_(std::move(channel)),
      tell_(std::move(tell)) {}

void SocketcandServer::wait(double seconds) const {
  std::vector<pollfd> waiting{{listening_.number(), POLLIN, 0}};
  for (const Client& client : clients_) {
    const int events = (client.held ? 0 : POLLIN) | (client.unsent.empty() ? 0 : POLLOUT);
    if (client.leaving.empty()) waiting.push_back({client.socket.number(), static_cast<short>(events), 0});
  }
  const double whole_s = std::floor(std::max(seconds, 0.0));
  const timespec left{static_cast<time_t>(whole_s),
                      static_cast<long>((std::max(seconds, 0.0) - whole_s) * 1e9)};
  ::ppoll(waiting.data(), waiting.size(), &left, nullptr);
}

void SocketcandServer::exchange() {
  accept_clients();
  for (auto client = clients_.begin(); client != clients_.end();) {
    if (client->leaving.empty()) read(*client);
    if (client->leaving.empty()) do_what_is_due(*client);
    write(*client);
    const bool sent = client->port == nullptr || client->port->waiting_to_send() == 0;
    if (!client->leaving.empty() && sent) {
      leave(*client);
      client = clients_.erase(client);
    } else {
      ++client;
    }
  }
}

void SocketcandServer::collect(std::uint64_t time_us) {
  epoch_us_ = time_us - bus_.now_ns() / 1000;
  for (Client& client : clients_) {
    if (client.port == nullptr || !client.leaving.empty()) continue;
    for (CanFrame frame; client.port->receive(frame);) {
      client.received.add(frame);
      if (frame.remote || !wants(client, frame)) continue;  // the protocol has no remote frames
      hand_on(client, frame, time_us);
    }
  }
}

void SocketcandServer::hand_on(Client& client, const CanFrame& frame, std::uint64_t time_us) {
  const bool is_quiet = std::chrono::steady_clock::now() < client.quiet_until || !client.kept_back.empty();
  std::string& to = is_quiet ? client.kept_back : client.unsent;
  // python-can 4.1, Debian 12's, loses one byte where a piece of the stream ends: it may have this one.
  to += '\n';
  to += wire::frame_message(frame, time_us);
  ++counters_.frames_handed;
}

void SocketcandServer::accept_clients() {
  while (wire::FileDescriptor socket = wire::accept_tcp(listening_)) {
    Client& client = clients_.emplace_back();
    client.socket = std::move(socket);
    client.number = ++connections_;
    client.unsent = "< hi >";
    if (clients_.size() > kClients) {
      client.unsent = "< error no room for more than " + std::to_string(kClients) + " clients >";
      drop(client, "is one more than " + std::to_string(kClients));
    }
  }
}

/// Takes a bounded piece of what the client wrote; nothing while a frame of it waits for room on the bus.
void SocketcandServer::read(Client& client) {
  handle_messages(client);
  if (client.held) return;
  std::array<char, 4096> bytes;
  const ssize_t count = ::recv(client.socket.number(), bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (count <= 0) {
    client.leaving = "has gone";
    return;
  }
  if (!client.reader.append({bytes.data(), static_cast<std::size_t>(count)})) {
    drop(client, "wrote " + std::to_string(wire::MessageReader::kLongest) +
                     " bytes without a message, expected those of socketcand");
    return;
  }
  handle_messages(client);
}

void SocketcandServer::handle_messages(Client& client) {
  while (client.leaving.empty()) {
    if (client.held) {
      if (!client.port->send(*client.held)) return;
      client.sent.add(*client.held);
      client.held.reset();
      ++counters_.frames_taken;
    }
    const std::optional<std::string> message = client.reader.next();
    if (!message) return;
    handle(client, *message);
  }
}

void SocketcandServer::handle(Client& client, const std::string& message) {
  end_quiet(client);
  const std::vector<std::string_view> words = wire::words_of(message);
  const std::string_view command = words.empty() ? std::string_view() : words.front();
  if (client.mode == Mode::no_bus) {
    if (command == "open" && words.size() == 2) {
      open(client, words[1]);
      return;
    }
  } else if (command == "send") {
    client.held = wire::parse_send(words);
    if (client.held) return;
  } else if (message == "< rawmode >" || message == "< bcmmode >" || message == "< controlmode >") {
    client.mode = command == "rawmode"   ? Mode::raw
                  : command == "bcmmode" ? Mode::broadcast_manager
                                         : Mode::control;
    client.subscribed.clear();
    client.jobs.clear();
    client.statistics_ns = 0;
    client.unsent += "< ok >";
    // python-can takes nothing for the answer that has a frame behind it in one piece: it gets time to read it.
    client.quiet_until = std::chrono::steady_clock::now() + std::chrono::milliseconds(10);
    return;
  } else if (message == "< echo >") {
    client.unsent += message;
    return;
  } else if ((client.mode == Mode::broadcast_manager && handle_broadcast(client, words)) ||
             (client.mode == Mode::control && handle_control(client, words))) {
    return;
  }
  client.unsent += "< error unknown command >";
}

/// False: no command of this mode, or an impossible one, and nothing has changed.
bool SocketcandServer::handle_broadcast(Client& client, std::span<const std::string_view> words) {
  if (words.size() < 2) return false;
  const auto key_of = [](const CanFrame& frame) { return Key{frame.extended, frame.id}; };
  const std::string_view command = words[0];
  if (words.size() == 2) {
    const auto frame = wire::parse_identifier(words[1]);
    if (!frame) return false;
    if (command == "unsubscribe") client.subscribed.erase(key_of(*frame));
    if (command == "delete") client.jobs.erase(key_of(*frame));
    return command == "unsubscribe" || command == "delete";
  }
  if (command == "update") {
    const auto frame = wire::parse_content(words.subspan(1));
    const auto job = frame ? client.jobs.find(key_of(*frame)) : client.jobs.end();
    if (job == client.jobs.end()) return false;
    job->second.frame = *frame;
    return true;
  }
  if (words.size() < 4) return false;
  const auto interval_us = wire::parse_interval_us(words[1], words[2]);
  if (!interval_us) return false;
  if (command == "subscribe") {
    const auto frame = wire::parse_identifier(words[3]);
    if (!frame || words.size() != 4) return false;
    client.subscribed[key_of(*frame)] = {.every_ns = 1000 * *interval_us};
    return true;
  }
  const auto frame = wire::parse_content(words.subspan(3));
  if (!frame) return false;
  if (command == "filter") {
    client.subscribed[key_of(*frame)] = {.mask = frame, .every_ns = 1000 * *interval_us};
    return true;
  }
  if (command != "add" || *interval_us == 0) return false;
  if (client.jobs.size() == kJobs && !client.jobs.contains(key_of(*frame))) return false;
  client.jobs[key_of(*frame)] = {.frame = *frame, .every_ns = 1000 * *interval_us, .due_ns = bus_.now_ns()};
  return true;
}

bool SocketcandServer::handle_control(Client& client, std::span<const std::string_view> words) {
  if (words.size() != 2 || words[0] != "statistics") return false;
  const auto every_ms = wire::parse_interval_us("0", words[1]);
  if (!every_ms) return false;
  client.statistics_ns = 1'000'000 * *every_ms;
  client.statistics_due_ns = bus_.now_ns() + client.statistics_ns;
  return true;
}

void SocketcandServer::end_quiet(Client& client) {
  client.quiet_until = {};
  client.unsent += std::exchange(client.kept_back, {});
}

/// A job that the bus has no room for misses a turn.
void SocketcandServer::do_what_is_due(Client& client) {
  if (std::chrono::steady_clock::now() >= client.quiet_until) end_quiet(client);
  const std::uint64_t now_ns = bus_.now_ns();
  for (auto& [key, job] : client.jobs) {
    for (; job.due_ns <= now_ns; job.due_ns += job.every_ns) {
      if (!client.port->send(job.frame)) {
        job.due_ns = now_ns + job.every_ns;
        break;
      }
      client.sent.add(job.frame);
    }
  }
  for (auto& [key, subscription] : client.subscribed) {
    if (!subscription.early || now_ns < subscription.due_ns) continue;
    hand_on(client, *subscription.early, epoch_us_ + now_ns / 1000);
    subscription.early.reset();
    subscription.due_ns = now_ns + subscription.every_ns;
  }
  if (client.statistics_ns == 0 || now_ns < client.statistics_due_ns) return;
  client.statistics_due_ns = now_ns + client.statistics_ns;
  client.unsent += "< stat";
  for (const std::uint64_t figure :
       {client.received.bytes, client.received.frames, client.sent.bytes, client.sent.frames}) {
    client.unsent += ' ' + std::to_string(figure);
  }
  client.unsent += " >";
}

bool SocketcandServer::wants(Client& client, const CanFrame& frame) {
  if (client.mode == Mode::raw) return true;
  const auto found = client.subscribed.find({frame.extended, frame.id});
  if (found == client.subscribed.end()) return false;
  Subscription& subscription = found->second;
  const auto same = [&](std::size_t i) {
    return ((frame.data[i] ^ subscription.last->data[i]) & subscription.mask->data[i]) == 0;
  };
  bool changed = !subscription.mask || !subscription.last || subscription.last->length != frame.length;
  for (std::size_t i = 0; !changed && i < frame.length; ++i) changed = !same(i);
  if (!changed) return false;
  if (subscription.mask) subscription.last = frame;
  if (bus_.now_ns() < subscription.due_ns) {
    subscription.early = frame;
    return false;
  }
  subscription.due_ns = bus_.now_ns() + subscription.every_ns;
  subscription.early.reset();
  return true;
}

void SocketcandServer::open(Client& client, std::string_view channel) {
  if (channel != channel_) {
    client.unsent += "< error could not open bus >";
    client.leaving = "asked for " + std::string(channel) + ", expected " + channel_;
    return;
  }
  if (free_ports_.empty()) {
    client.port = &bus_.attach("socketcand client");
  } else {
    client.port = free_ports_.back();
    free_ports_.pop_back();
    client.port->set_state(CanState::error_active);
  }
  client.mode = Mode::broadcast_manager;
  client.unsent += "< ok >";
  ++counters_.clients;
  tell_("client " + std::to_string(client.number) + " has joined");
}

void SocketcandServer::write(Client& client) {
  std::size_t done = 0;
  while (done < client.unsent.size()) {
    const ssize_t count = ::send(client.socket.number(), client.unsent.data() + done,
                                 client.unsent.size() - done, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno != EAGAIN && client.leaving.empty()) client.leaving = "has gone";
    if (count < 0) break;
    done += static_cast<std::size_t>(count);
  }
  client.unsent.erase(0, done);
  if (client.unsent.size() > kUnsentBytes && client.leaving.empty()) {
    drop(client, "does not read: " + std::to_string(client.unsent.size()) + " bytes wait for it");
  }
}

/// A port cannot leave its bus: off the bus it neither sends nor hears, until the next client takes it.
void SocketcandServer::leave(Client& client) {
  tell_("client " + std::to_string(client.number) + ' ' + client.leaving);
  if (client.port == nullptr) return;
  client.port->set_state(CanState::bus_off);
  for (CanFrame frame; client.port->receive(frame);) {
  }
  free_ports_.push_back(client.port);
}

void SocketcandServer::drop(Client& client, const std::string& why) {
  ++counters_.dropped;
  client.leaving = "dropped: it " + why;
}

}  // namespace plenum::host::ports
