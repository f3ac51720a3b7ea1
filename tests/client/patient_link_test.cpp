#include "host-sim/client/patient_link.hpp"

#include <gtest/gtest.h>

#include "host-sim/client/sdo_client.hpp"
#include "tests/firmware/canopen/bench.hpp"

namespace plenum::host::client {
namespace {

/// Answers 1000h:0, once, this long after it was asked.
class LateServer final : public Link {
 public:
  explicit LateServer(double delay_s) : delay_s_(delay_s) {}

  void send(const CanFrame&) override {
    if (answer_s_ < 0.0) answer_s_ = now_s_ + delay_s_;
  }
  std::optional<CanFrame> receive(double timeout_s) override {
    const bool comes = now_s_ < answer_s_ && answer_s_ <= now_s_ + timeout_s;
    now_s_ = comes ? answer_s_ : now_s_ + timeout_s;
    if (!comes) return std::nullopt;
    return canopen::frame_from("585 43 00 10 00 98 01 02 00");
  }
  double now_s() const override { return now_s_; }

 private:
  double delay_s_;
  double answer_s_ = -1.0;
  double now_s_ = 0.0;
};

TEST(PatientLink, TakesAnAnswerThatComesLaterThanTheTimeOutByNoMoreThanItsFactor) {
  constexpr SdoConfig kConfig{.timeout_s = 0.5};
  const auto ask = [&](double delay_s, double patience) {
    PatientLink link(std::make_unique<LateServer>(delay_s), patience);
    return SdoClient(link, 5, kConfig, {}).read(0x1000, 0);
  };
  const std::vector<std::uint8_t> device_type{0x98, 0x01, 0x02, 0x00};
  EXPECT_EQ(ask(0.4, 1.0), device_type);
  EXPECT_THROW(ask(0.6, 1.0), Timeout);
  EXPECT_EQ(ask(1.9, 4.0), device_type);
  EXPECT_THROW(ask(2.1, 4.0), Timeout);
}

TEST(PatientLink, TellsATimeOfItsOwnByWhichAWaitLastsAsLongAsItWasAskedTo) {
  PatientLink link(std::make_unique<LateServer>(0.0), 10.0);
  const double begin_s = link.now_s();
  EXPECT_FALSE(link.receive(0.25));
  EXPECT_DOUBLE_EQ(link.now_s() - begin_s, 0.25);
}

}  // namespace
}  // namespace plenum::host::client
