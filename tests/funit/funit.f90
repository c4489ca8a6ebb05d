module funit
  !! Stand-in for the few assertions of pFUnit that beamwave's tests use, for machines without pFUnit.
  !!
  !! `directives.awk` turns each directive of a `.pf` file into a call of this module, followed by a
  !! return when anything has failed. Numbers are carried in binary128; a difference is rounded to
  !! binary64 before it meets the tolerance, as if it had been taken there.
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_is_nan
  use, intrinsic :: ieee_exceptions, only: ieee_all, ieee_get_status, ieee_set_halting_mode, ieee_set_status, &
    ieee_status_type
  use, intrinsic :: iso_fortran_env, only: int32, int64, output_unit, real64, real128
  use funit_numbers, only: numbers_of, numbers_type, text_of
  implicit none (type, external)
  private
  public :: assertEqual, assertRelativelyEqual, assertLessThanOrEqual, assertTrue, assertFalse
  public :: anyExceptions, SourceLocation, start_tests, run_test, finish_tests

  ! All other public names of pFUnit 4.14: a test module that defines or uses another thing of that name does not compile with it.
  ! First those of types: gfortran 12 may take a variable of a procedure for the type, so directives.awk refuses them, too.
  integer, parameter, public :: abstractmatcher = 0, abstracttestparameter = 0, allof = 0, anyof = 0, &
    basetestrunner = 0, debuglistener = 0, every = 0, expectation = 0, is = 0, isarraywithsize = 0, isequal = 0, &
    isnear = 0, isnot = 0, isrelativelynear = 0, istrueorfalse = 0, listenerpointer = 0, matchable = 0, &
    matcherdescription = 0, namefilter = 0, parallelcontext = 0, parameterizedtestcase = 0, predicate = 0, &
    remoterunner = 0, resultprinter = 0, robustrunner = 0, serialcontext = 0, stringcontains = 0, &
    stringdescription = 0, stringendswith = 0, stringstartswith = 0, subject = 0, taplistener = 0, test = 0, &
    testannotation = 0, testcase = 0, testlistener = 0, testlistenervector = 0, testmethod = 0, testresult = 0, &
    testrunner = 0, testsuite = 0, timeoutannotation = 0, wascalled = 0, wascalledonce = 0, wasnotcalled = 0, &
    whitespaceoptions = 0, xmlprinter = 0
  integer, parameter, public :: all_of = 0, any_of = 0, array_with_size = 0, assert_that = 0, assertall = 0, &
    assertany = 0, assertexceptionraised = 0, assertfail = 0, assertgreaterthan = 0, assertgreaterthanorequal = 0, &
    assertisfinite = 0, assertisnan = 0, assertlessthan = 0, assertnone = 0, assertnotall = 0, assertnotequal = 0, &
    assertsameshape = 0, catch = 0, catchnext = 0, contains_string = 0, disable = 0, empty_array = 0, ends_with = 0, &
    equal_to = 0, every_item = 0, false = 0, finalize = 0, generic_run = 0, get_context = 0, ignore_all = 0, &
    ignore_differences = 0, initialize = 0, keep_all = 0, loadtests_interface = 0, near = 0, not = 0, &
    relatively_near = 0, run = 0, starts_with = 0, stub = 0, throw = 0, trim_all = 0, true = 0

  type :: SourceLocation
    !! Where an assertion stands.
    character(:), allocatable :: file
    integer :: line = 0
  end type SourceLocation

  abstract interface
    pure logical function rule(expected, actual, tolerance)
      !! Whether two numbers, neither of them NaN, pass.
      import :: real64, real128
      implicit none (type, external)
      real(real128), intent(in) :: expected, actual
      real(real64), intent(in) :: tolerance
    end function rule
    subroutine test_procedure()
      implicit none (type, external)
    end subroutine test_procedure
  end interface

  interface assertEqual
    !! (expected, actual, tolerance, message): passes if a == e or |a − e| ≤ tolerance, which is 0 when
    !! absent. The expected value may be a scalar, and stands then for each element.
    module procedure :: equal_reals, equal_integers, equal_longs, equal_integer_longs, equal_characters
  end interface assertEqual

  interface assertLessThanOrEqual
    !! (a, b, message): passes if a ≤ b.
    module procedure :: ordered_reals, ordered_integers, ordered_longs
  end interface assertLessThanOrEqual

  real(real64), parameter :: exact = 0  !! the tolerance of what takes none
  integer :: tests_run = 0
  integer :: tests_failed = 0
  logical :: has_failed = .false.  !! the running test

contains

  subroutine start_tests(program_name)
    character(*), intent(in) :: program_name
    write (output_unit, '(a)') program_name//': run by the stand-in for pFUnit in tests/funit'
  end subroutine start_tests

  subroutine run_test(suite, name, test)
    !! The name is written before the test runs, so that a crash is told by the last line; behind it the CPU time that it took.
    character(*), intent(in) :: suite, name
    procedure(test_procedure) :: test
    real(real64) :: begin, end
    write (output_unit, '(a)') '  '//suite//': '//name
    flush (output_unit)
    has_failed = .false.
    call cpu_time(begin)
    call test()
    call cpu_time(end)
    write (output_unit, '(f12.2,a)') end - begin, ' s'
    tests_run = tests_run + 1
    if (has_failed) tests_failed = tests_failed + 1
  end subroutine run_test

  subroutine finish_tests()
    !! The closing line. Exit status 1 on any failure, and when there was nothing to run.
    write (output_unit, '(2(a,i0),a)') 'Tests run: ', tests_run, ', Failures: ', tests_failed, ', Errors: 0'
    flush (output_unit)
    if (tests_failed > 0 .or. tests_run == 0) stop 1, quiet=.true.
  end subroutine finish_tests

  logical function anyExceptions()
    !! Whether an assertion of the running test has failed.
    anyExceptions = has_failed
  end function anyExceptions

  subroutine assertTrue(condition, message, location)
    logical, intent(in) :: condition
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in) :: location
    if (.not. condition) call report('assertTrue: the condition is false', message, location)
  end subroutine assertTrue

  subroutine assertFalse(condition, message, location)
    logical, intent(in) :: condition
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in) :: location
    if (condition) call report('assertFalse: the condition is true', message, location)
  end subroutine assertFalse

  subroutine assertRelativelyEqual(expected, actual, tolerance, message, location)
    !! Passes if |a − e| ≤ tolerance |e|. An expected 0 fails: no number is relatively close to it.
    real(real64), intent(in) :: expected(..), actual(..), tolerance
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in) :: location
    call compare('assertRelativelyEqual', is_relatively_close, numbers_of(expected), numbers_of(actual), tolerance, &
      message, location)
  end subroutine assertRelativelyEqual

  subroutine equal_reals(expected, actual, tolerance, message, location)
    real(real64), intent(in) :: expected(..), actual(..)
    real(real64), intent(in), optional :: tolerance
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in) :: location
    real(real64) :: allowed
    allowed = exact
    if (present(tolerance)) allowed = tolerance
    call compare('assertEqual', is_close, numbers_of(expected), numbers_of(actual), allowed, message, location)
  end subroutine equal_reals

  subroutine equal_integers(expected, actual, message, location)
    integer(int32), intent(in) :: expected(..), actual(..)
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in) :: location
    call compare('assertEqual', is_close, numbers_of(expected), numbers_of(actual), exact, message, location)
  end subroutine equal_integers

  subroutine equal_longs(expected, actual, message, location)
    integer(int64), intent(in) :: expected(..), actual(..)
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in) :: location
    call compare('assertEqual', is_close, numbers_of(expected), numbers_of(actual), exact, message, location)
  end subroutine equal_longs

  subroutine equal_integer_longs(expected, actual, message, location)
    integer(int32), intent(in) :: expected(..)
    integer(int64), intent(in) :: actual(..)
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in) :: location
    call compare('assertEqual', is_close, numbers_of(expected), numbers_of(actual), exact, message, location)
  end subroutine equal_integer_longs

  subroutine equal_characters(expected, actual, message, location)
    !! Blanks at both ends do not count, nor do they in pFUnit.
    character(*), intent(in) :: expected, actual
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in) :: location
    if (adjustl(expected) == adjustl(actual)) return
    call report("assertEqual: expected '"//expected//"', actual '"//actual//"'", message, location)
  end subroutine equal_characters

  subroutine ordered_reals(a, b, message, location)
    real(real64), intent(in) :: a(..), b(..)
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in) :: location
    call compare('assertLessThanOrEqual', is_ordered, numbers_of(a), numbers_of(b), exact, message, location)
  end subroutine ordered_reals

  subroutine ordered_integers(a, b, message, location)
    integer(int32), intent(in) :: a(..), b(..)
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in) :: location
    call compare('assertLessThanOrEqual', is_ordered, numbers_of(a), numbers_of(b), exact, message, location)
  end subroutine ordered_integers

  subroutine ordered_longs(a, b, message, location)
    integer(int64), intent(in) :: a(..), b(..)
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in) :: location
    call compare('assertLessThanOrEqual', is_ordered, numbers_of(a), numbers_of(b), exact, message, location)
  end subroutine ordered_longs

  pure logical function is_close(expected, actual, tolerance)
    real(real128), intent(in) :: expected, actual
    real(real64), intent(in) :: tolerance
    is_close = actual == expected
    if (.not. is_close .and. ieee_is_finite(expected)) is_close = abs(real(actual - expected, real64)) <= tolerance
  end function is_close

  pure logical function is_relatively_close(expected, actual, tolerance)
    real(real128), intent(in) :: expected, actual
    real(real64), intent(in) :: tolerance
    is_relatively_close = .false.
    if (expected == 0 .or. .not. ieee_is_finite(expected)) return
    is_relatively_close = abs(real(actual - expected, real64)) <= tolerance*abs(real(expected, real64))
  end function is_relatively_close

  pure logical function is_ordered(expected, actual, tolerance)
    real(real128), intent(in) :: expected, actual
    real(real64), intent(in) :: tolerance
    is_ordered = expected <= actual + tolerance
  end function is_ordered

  subroutine compare(name, passes, expected, actual, tolerance, message, location)
    !! Report the first element that does not pass. Traps are off meanwhile: a NaN or an overflow in
    !! what is compared is a failed assertion, not a crash.
    character(*), intent(in) :: name
    procedure(rule) :: passes
    type(numbers_type), intent(in) :: expected, actual
    real(real64), intent(in) :: tolerance
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in) :: location
    type(ieee_status_type) :: status
    real(real128) :: e, a
    integer :: i
    if (.not. expected%fits(actual)) then
      call report(name//': the shapes differ', message, location)
      return
    end if
    call ieee_get_status(status)
    call ieee_set_halting_mode(ieee_all, .false.)
    do i = 1, size(actual%list)
      e = expected%list(min(i, size(expected%list)))
      a = actual%list(i)
      if (.not. (ieee_is_nan(e) .or. ieee_is_nan(a))) then
        if (passes(e, a, tolerance)) cycle
      end if
      call report(name//actual%place_of(i)//': expected '//text_of(e)//', actual '//text_of(a)//', difference '// &
        text_of(a - e)//', tolerance '//text_of(real(tolerance, real128)), message, location)
      exit
    end do
    call ieee_set_status(status)
  end subroutine compare

  subroutine report(what, message, location)
    character(*), intent(in) :: what
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in) :: location
    character(12) :: line
    has_failed = .true.
    write (line, '(i0)') location%line
    write (output_unit, '(a)') '    FAILED '//location%file//':'//trim(line)//': '//what
    if (present(message)) write (output_unit, '(a)') '      '//message
  end subroutine report

end module funit
