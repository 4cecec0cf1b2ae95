#include <memory>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include <wayfare/core/contract.hpp>
#include <wayfare/core/result.hpp>

namespace wayfare {
namespace {

Result<int> half_of(int n) {
  if (n % 2 != 0) {
    return Error{.code = ErrorCode::invalid, .message = "odd", .source = "n", .line = 3};
  }
  return n / 2;
}

TEST(Result, ContainsAValueOrAnError) {
  const Result<int> good = half_of(8), bad = half_of(7);
  ASSERT_TRUE(good);
  EXPECT_EQ(*good, 4);
  EXPECT_EQ(good.value_or(-1), 4);
  ASSERT_FALSE(bad.has_value());
  EXPECT_EQ(bad.error().code, ErrorCode::invalid);
  EXPECT_EQ(bad.value_or(-1), -1);
}

TEST(Result, SupportsMoveOnlyValues) {
  Result<std::unique_ptr<int>> result(std::make_unique<int>(5));
  const std::unique_ptr<int> taken = std::move(result).value();
  EXPECT_EQ(*taken, 5);
  EXPECT_EQ(*Result<std::string>(std::string("a"))->begin(), 'a');
}

TEST(Result, VoidDistinguishesSuccessFromFailure) {
  EXPECT_TRUE(Result<void>());
  const Result<void> failed = Error{ErrorCode::io, "disk full"};
  EXPECT_FALSE(failed);
  EXPECT_EQ(failed.error().message, "disk full");
}

TEST(Error, ReportsTheLocationInTheFormEditorsRecognise) {
  EXPECT_EQ((Error{.message = "m"}).to_string(), "m");
  EXPECT_EQ((Error{.message = "m", .source = "f.log", .line = 12}).to_string(), "f.log:12: m");
  EXPECT_EQ((Error{.message = "m", .source = "f.bin", .byte = 7}).to_string(), "f.bin, byte 7: m");
  EXPECT_EQ((Error{.message = "m", .line = 12}).to_string(), "line 12: m");
  EXPECT_EQ((Error{.message = "m", .byte = 9}).to_string(), "byte 9: m");
}

struct Violation : std::logic_error {
  using std::logic_error::logic_error;
};

/// Converts violations to exceptions for the duration of a test.
class Contract : public ::testing::Test {
 protected:
  Contract() {
    previous_ = set_contract_handler([](const ContractViolation& v) {
      throw Violation(std::string(v.condition) + "|" + v.message + "|" + v.function);
    });
  }
  ~Contract() override { set_contract_handler(previous_); }

 private:
  ContractHandler previous_;
};

std::string violation_of(void (*call)()) {
  try {
    call();
  } catch (const Violation& v) {
    return v.what();
  }
  return "none";
}

void take_positive(int n) { WAYFARE_EXPECTS(n > 0, "a count is positive"); }

TEST_F(Contract, ReportsConditionMessageAndLocation) {
  EXPECT_EQ(violation_of([] { take_positive(1); }), "none");
  const std::string what = violation_of([] { take_positive(0); });
  EXPECT_NE(what.find("n > 0|a count is positive|"), std::string::npos) << what;
  EXPECT_NE(what.find("take_positive"), std::string::npos) << what;
}

TEST_F(Contract, ChecksAccessToTheMissingSideOfAResult) {
  EXPECT_NE(violation_of([] { (void)half_of(7).value(); }).find("odd"), std::string::npos);
  EXPECT_NE(violation_of([] { (void)half_of(8).error(); }).find("no error"), std::string::npos);
  EXPECT_NE(violation_of([] { (void)Result<void>().error(); }).find("no error"), std::string::npos);
}

TEST_F(Contract, HandlersAreReplacedAndRestored) {
  const ContractHandler mine = set_contract_handler(nullptr);
  const ContractHandler standard = set_contract_handler(mine);
  EXPECT_NE(mine, standard);
  EXPECT_EQ(set_contract_handler(mine), mine);
}

TEST(ContractDeathTest, TheDefaultHandlerPrintsTheReasonAndAborts) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_DEATH(take_positive(-1), "result_test.cpp:.*'n > 0' violated: a count is positive");
}

}  // namespace
}  // namespace wayfare
