#include "tests/safety/fault_matrix.hpp"

#include <gtest/gtest.h>

namespace plenum::safety_case {
namespace {

/// One test a row, of a dozen seeds each; tests/bench/safety.cpp takes ten thousand.
class FaultMatrix : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(FaultMatrix, EndsEveryRunSafeToldOnTheBusAndLeftByAResetOnly) {
  for (std::uint64_t draw = 0; draw < 12; ++draw) EXPECT_EQ(lost_in_run(GetParam() + draw * rows()), "");
}

INSTANTIATE_TEST_SUITE_P(Rows, FaultMatrix, ::testing::Range(std::uint64_t{0}, std::uint64_t{rows()}),
                         [](const auto& instance) {
                           std::string name = row_of(instance.param);
                           std::erase_if(
                               name, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; });
                           return name;
                         });

}  // namespace
}  // namespace plenum::safety_case
