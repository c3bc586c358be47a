#include <doctest/doctest.h>

#include "stickslip/isa.hpp"

using namespace stickslip;

TEST_CASE("the instruction set in use is compiled in and supported by this processor") {
  CHECK(is_compiled(isa_in_use()));
  CHECK(is_supported(isa_in_use()));
  CHECK(is_compiled(Isa::baseline));
  CHECK(is_supported(Isa::baseline));
}

TEST_CASE("the facts of each instruction set stand at its own index, each wider than the one before") {
  for (const IsaFacts& fact : isa_facts) CHECK(facts(fact.isa).name == fact.name);
  CHECK(facts(Isa::baseline).lanes < facts(Isa::avx2).lanes);
  CHECK(facts(Isa::avx2).lanes < facts(Isa::avx512).lanes);
}
