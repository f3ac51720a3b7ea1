#include "host-sim/report/encoding.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <string_view>
#include <vector>

namespace plenum::host::report {
namespace {

std::string base64_of(std::string_view text) {
  return base64(std::vector<unsigned char>(text.begin(), text.end()));
}

TEST(Encoding, Base64GivesTheVectorsOfRfc4648) {
  EXPECT_EQ(base64_of(""), "");
  EXPECT_EQ(base64_of("f"), "Zg==");
  EXPECT_EQ(base64_of("fo"), "Zm8=");
  EXPECT_EQ(base64_of("foo"), "Zm9v");
  EXPECT_EQ(base64_of("foob"), "Zm9vYg==");
  EXPECT_EQ(base64_of("fooba"), "Zm9vYmE=");
  EXPECT_EQ(base64_of("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64_of("\xff\xfe\xfd"), "//79");
}

TEST(Encoding, HtmlEscapesEveryCharacterThatCouldLeaveATextOrAnAttribute) {
  EXPECT_EQ(escape_html("<a href=\"x\">Tom's & co</a>"),
            "&lt;a href=&quot;x&quot;&gt;Tom&#39;s &amp; co&lt;/a&gt;");
}

TEST(Encoding, NoTextInJsonCanCloseItsScript) {
  const nlohmann::ordered_json hostile = {"</script><script>alert(1)</script>", "<!--", "broken \xff byte"};
  const std::string safe = script_safe(hostile);
  EXPECT_EQ(safe.find('<'), std::string::npos);
  const auto back = nlohmann::ordered_json::parse(safe);
  EXPECT_EQ(back[0], hostile[0]);
  EXPECT_EQ(back[2], "broken \xef\xbf\xbd byte");
}

TEST(Encoding, NumbersReadAsPeopleWriteThem) {
  EXPECT_EQ(significant(0.0), "0");
  EXPECT_EQ(significant(3.14159), "3.142");
  EXPECT_EQ(significant(0.99996), "1");
  EXPECT_EQ(significant(-12.5), "−12.5");
  EXPECT_EQ(significant(812.0), "812");
  EXPECT_EQ(significant(9999.4), "9999");
  EXPECT_EQ(significant(17345.0), "17\u202f345");
  EXPECT_EQ(significant(1234567.0), "1\u202f234\u202f567");
  EXPECT_EQ(significant(1.2e-8), "1.2×10⁻⁸");
  EXPECT_EQ(significant(3.0e12), "3×10¹²");
  EXPECT_EQ(significant(0.00012), "0.00012");
  EXPECT_EQ(significant(std::nan("")), "–");
  EXPECT_EQ(significant(std::numeric_limits<double>::infinity()), "–");
}

TEST(Encoding, NumbersOfAColumnHaveItsDecimals) {
  EXPECT_EQ(fixed(1.5, 2), "1.50");
  EXPECT_EQ(fixed(31.149, 2), "31.15");
  EXPECT_EQ(fixed(-0.126, 2), "−0.13");
  EXPECT_EQ(fixed(-0.001, 2), "0.00");
  EXPECT_EQ(fixed(0.0, 0), "0");
  EXPECT_EQ(fixed(9999.5, 1), "9999.5");
  EXPECT_EQ(fixed(123456.75, 1), "123\u202f456.8");
  EXPECT_EQ(fixed(std::nan(""), 2), "–");
}

TEST(ArrayPool, StoresAnEvenGridAsThreeNumbersAndEqualArraysOnce) {
  ArrayPool pool;
  std::vector<double> time_s;
  for (int i = 0; i < 1000; ++i) time_s.push_back(0.01 * i);
  const std::size_t time = pool.add(time_s);
  const std::size_t curve = pool.add(std::vector<double>{1.0, -2.5, 7.0});
  EXPECT_EQ(pool.add(time_s), time);
  EXPECT_EQ(pool.add(std::vector<double>{1.0, -2.5, 7.0}), curve);
  ASSERT_EQ(pool.json().size(), 2U);
  EXPECT_EQ(pool.json()[time]["count"], 1000);
  EXPECT_NEAR(pool.json()[time]["step"].get<double>(), 0.01, 1e-12);
}

TEST(ArrayPool, StoresFloatsLittleEndianAndEveryNonFiniteValueAsNaN) {
  ArrayPool pool;
  // 1.0f is 3f800000, -2.5f is c0200000; base64 by hand from the little-endian bytes.
  pool.add(std::vector<double>{1.0, -2.5});
  EXPECT_EQ(pool.json()[0]["f32"], "AACAPwAAIMA=");
  pool.add(std::vector<double>{std::numeric_limits<double>::infinity()});
  pool.add(std::vector<double>{1e300});
  EXPECT_EQ(pool.json().size(), 2U) << "infinity and what overflows a float are the same gap";
  EXPECT_EQ(pool.json()[1]["f32"], "AADAfw==");
}

}  // namespace
}  // namespace plenum::host::report
