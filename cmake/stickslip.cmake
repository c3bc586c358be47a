# What every target of this project shares, and the kernel compiled once per instruction set.

function(stickslip_require_eigen)
  find_package(Eigen3 QUIET NO_MODULE)
  if(NOT TARGET Eigen3::Eigen)
    message(FATAL_ERROR "stickslip needs the Eigen headers, 3.4 or later, and found none. Install them:\n"
      "  Debian, Ubuntu:  apt-get install libeigen3-dev\n"
      "  Fedora:          dnf install eigen3-devel\n"
      "  conda:           conda install -c conda-forge eigen\n"
      "If they are in a place of your own, set the environment variable Eigen3_DIR to the folder that holds "
      "Eigen3Config.cmake.")
  endif()
endfunction()

set(STICKSLIP_GENERATED ${PROJECT_BINARY_DIR}/generated)

# Write stickslip/<folder>/all.hpp: it includes every header of that folder and lists their types. A folder changes
# when a file comes or goes, so the build then configures itself anew.
function(stickslip_type_list folder types names)
  set(sources ${PROJECT_SOURCE_DIR}/cpp/include/stickslip/${folder})
  set(script ${PROJECT_SOURCE_DIR}/cmake/type_lists.py)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${sources} ${script})
  execute_process(COMMAND ${Python_EXECUTABLE} ${script} ${sources} ${types} ${names}
                          ${STICKSLIP_GENERATED}/stickslip/${folder}/all.hpp
                  COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# Warnings, optimisation and sanitizers of one target. GCC's guess that something may be uninitialised
# changes with every release and with what is inlined; it is shown, and is no error.
function(stickslip_settings target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wconversion -Wshadow
    $<$<BOOL:${STICKSLIP_WERROR}>:-Werror> $<$<CXX_COMPILER_ID:GNU>:-Wno-error=maybe-uninitialized>
    $<$<CONFIG:Release>:-O3> -fno-math-errno -ffp-contract=fast)
  if(STICKSLIP_SANITIZE)
    set(sanitize -fsanitize=${STICKSLIP_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
    target_compile_options(${target} PRIVATE ${sanitize})
    target_link_options(${target} PRIVATE ${sanitize})
  endif()
endfunction()

# macOS may build for another processor than the one it runs on
set(STICKSLIP_TARGET "${CMAKE_OSX_ARCHITECTURES}")
if(NOT STICKSLIP_TARGET)
  set(STICKSLIP_TARGET ${CMAKE_SYSTEM_PROCESSOR})
endif()
if(STICKSLIP_TARGET MATCHES "^(x86_64|AMD64)$")
  set(STICKSLIP_X86 ON)
endif()
set(STICKSLIP_ISAS baseline avx2 avx512 CACHE STRING "instruction sets to compile the kernel for")

# Compile `sources` into `library` for one instruction set, in the namespace stickslip::<isa>, for
# vectors of `lanes` doubles. The other arguments are the compiler flags that select the set. The
# namespace keeps the linker from merging an inline function of one set with another's.
function(stickslip_kernel library isa lanes sources)
  if(STICKSLIP_X86)
    set(flags ${ARGN})
  elseif(NOT isa STREQUAL "baseline")
    return()
  endif()
  if(NOT isa IN_LIST STICKSLIP_ISAS)
    return()
  endif()
  list(TRANSFORM sources PREPEND ${PROJECT_SOURCE_DIR}/)
  add_library(kernel_${isa} OBJECT ${sources})
  target_include_directories(kernel_${isa} PRIVATE ${PROJECT_SOURCE_DIR}/cpp/include ${STICKSLIP_GENERATED})
  target_link_libraries(kernel_${isa} PRIVATE Eigen3::Eigen)
  target_compile_definitions(kernel_${isa} PRIVATE STICKSLIP_ISA=${isa} STICKSLIP_LANES=${lanes})
  target_compile_options(kernel_${isa} PRIVATE ${flags})
  stickslip_settings(kernel_${isa})
  string(TOUPPER ${isa} upper)
  target_compile_definitions(${library} PUBLIC STICKSLIP_HAS_${upper})
  target_sources(${library} PRIVATE $<TARGET_OBJECTS:kernel_${isa}>)
endfunction()

# Tell one source file what build_config() reports.
function(stickslip_build_facts source)
  string(TOUPPER "CMAKE_CXX_FLAGS_${CMAKE_BUILD_TYPE}" typed)
  string(STRIP "${CMAKE_CXX_FLAGS} ${${typed}} -O3 -fno-math-errno -ffp-contract=fast" flags)
  set_source_files_properties(${PROJECT_SOURCE_DIR}/${source} PROPERTIES COMPILE_DEFINITIONS
    "STICKSLIP_VERSION=\"${PROJECT_VERSION}\";\
STICKSLIP_COMPILER=\"${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION}\";\
STICKSLIP_BUILD_TYPE=\"${CMAKE_BUILD_TYPE}\";\
STICKSLIP_FLAGS=\"${flags}\";\
STICKSLIP_SANITIZERS=\"${STICKSLIP_SANITIZE}\"")
endfunction()
