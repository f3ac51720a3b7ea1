// Recording a board's chambers over the bus, tick by tick, while the board excites them or follows set
// points.
//
// Both need the stream (one TPDO a chamber, each tick); they answer each of its rows with a SYNC. Row k holds
// what the board knew and did at one tick: the pressure averaged over the tick before, the command held from
// then on, the volume. A row whose frames did not all arrive is an error, not a gap.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "host-sim/client/session.hpp"

namespace plenum::host::client {

/// What is done and how far it is, for a progress line; `done` from 0 to 1.
using Progress = std::function<void(double done)>;

/// Asked each row; once it says true the recording ends there, as at its end. Empty: it goes on to its end.
using Stopped = std::function<bool()>;

struct CapturedRow {
  double time_s = 0.0;      ///< from the first row on
  double bus_time_s = 0.0;  ///< when its first frame came, in the time of the link
  std::array<StreamSample, kChambers> sample{};
  std::array<double, kChambers> reference_Pa{};  ///< follow() only: the reference at this row's time
  std::optional<double> supply_Pa{};  ///< mean over the tick just past, of a board that watches its supply
};

/// Who drives some chambers of a board drives all that are in use. Throws std::invalid_argument for one beyond the first `chambers`
/// that is (2410h + c:1); as a read does.
void require_none_left_out(Session& session, unsigned chambers);

struct CaptureOptions {
  double seconds = 60.0;
  std::uint32_t seed = 1;
  float command_low_V = 3.0F;
  float command_high_V = 7.0F;
  double pressure_low_Pa = 130'000.0;  ///< the guard turns the valve before the pressure leaves these
  double pressure_high_Pa = 600'000.0;
  double largest_volume_m3 = 3e-3;  ///< what the volume column can show
  unsigned chambers = 8;
  Stopped stopped = {};
  std::vector<CapturedRow>* so_far = nullptr;  ///< takes the rows from before an exception that ends the run
};

/// Excites the chambers on the board (control mode -1, no model needed) and records them. Leaves the node operational, the
/// board DISABLED and its settings and mode as they were (but for the excitation's, 2310h + c); also when it throws, as far as
/// the bus allows. Throws as Session does, before anything moves Refused for a board that regulates and std::invalid_argument for
/// limits that leave nothing within the board's settings and for a chamber in use that is left out; Refused when a fault ends it or
/// stands at the end, ProtocolError when a row is incomplete.
/// Returns fewer rows than asked for, or none, when stopped.
std::vector<CapturedRow> capture(Session& session, const CaptureOptions& options,
                                 const Progress& progress = {});

struct FollowOptions {
  std::uint8_t preview_ticks = 2;  ///< how far ahead of its time a set point is sent; 0..8
  bool open_loop = false;          ///< pure feedforward (control mode 3)
  double largest_volume_m3 = 3e-3;
  double highest_Pa = std::numeric_limits<double>::infinity();  ///< a pressure above ends the run, Refused
  unsigned chambers = 8;
  Stopped stopped = {};
  std::vector<CapturedRow>* so_far = nullptr;  ///< as in CaptureOptions
};

/// One reference [Pa, absolute] a chamber, sampled at 100 Hz, all of one length. The board regulates to them;
/// recorded. Leaves all as capture() does, 6394h too, so that a caller who sends set points configures them again. Throws as it,
/// std::invalid_argument for references that differ in length.
std::vector<CapturedRow> follow(Session& session, std::span<const std::vector<double>> reference_Pa,
                                const FollowOptions& options, const Progress& progress = {});

/// References for identification in closed loop, as the paper recorded its robot: each chamber ramps to
/// random pressures in [low, high] at random rates of 0.1 to 10 MPa/s and dwells there for 0.1 to 0.7 s. The
/// same seed gives the same.
std::vector<std::vector<double>> random_references(unsigned chambers, double seconds, double low_Pa,
                                                   double high_Pa, std::uint32_t seed);

}  // namespace plenum::host::client
