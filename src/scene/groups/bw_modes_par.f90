module bw_modes_par
  !! `&modes`: how many modes are summed.
  use bw_input_name, only: input_group, input_name, integer_input, logical_input, number_range, real_input
  use bw_input_values, only: group_values
  use bw_kinds, only: dp
  use bw_missing, only: is_missing, missing
  use bw_scene_messages, only: message_list
  use bw_text, only: text_of
  implicit none (type, external)
  private
  public :: build_modes, by_tolerance, is_relaxed, relaxed_tolerance, complete_modes, wanted_tolerance

  type, public :: modes_par
    integer :: before = 0   !! modes of the beam before the impact, ≥ 1
    integer :: after = 0    !! modes after the capture, ≥ 1; without a capture the same as before
    real(dp) :: tolerance = missing
      !! largest error of the displacement over its peak; `missing` if counts are given. With a tolerance, the counts are
      !! 0 before and `shown_modes` after
    logical :: asked = .true.
      !! false for the default tolerance, which is relaxed if it is out of reach
    logical :: extended = .false.
      !! every root in extended precision, whether needed or not. No input sets it: `beamwave accuracy` measures
      !! its cost
    logical :: modal_model = .false.   !! the result holds a modal model for other programs, at the points of histories
  end type modes_par

  integer, parameter, public :: shown_modes = 20      !! modes that a result holds if a tolerance sets their number
  integer, parameter :: default_count = 20            !! if no history depends on it
  real(dp), parameter, public :: default_tolerance = 1.0e-6_dp
  real(dp), parameter, public :: coarsest_tolerance = 0.5_dp
  type(number_range), parameter :: counts = number_range(1.0_dp, 1e7_dp)

  type(input_group), parameter, public :: modes_group = input_group( &
    'modes', implied=.true., &
    absent='20 modes; with `&response` as many as a tolerance of 1e-6 requires, or the finest that can be reached', &
    physics='Histories are sums over modes, and this group sets their number. With a tolerance the program chooses it: the '// &
    'tolerance bounds the estimated error of the displacement at any point, relative to the largest displacement; with '// &
    '`&contact`, `&force`, `&base`, `&initial` and bodies that come or leave, that of every requested history. The result '// &
    'holds the estimated errors in either case.', &
    example='&impact mass_ratio = 0.2 /|&capture /|&response duration = 1, samples = 4096 /|&modes tolerance = 1e-9 /', &
    rules='Give counts, or a tolerance. With `&capture` there are two sets of modes, and a count that is not given equals the '// &
    'other one. With bodies that come or leave, `before` counts the modes until the first change and `after` those of all '// &
    'later sets. Otherwise there is one set, whose count is `before`; `after`, if given, must equal it. With `&impact` but '// &
    'without `&capture` or `&contact` a `&response` needs a count: the impulse of an instantaneous rebound tends to 0 as modes '// &
    'are added, so that the motion depends on their number. An unreachable tolerance is refused; the default is relaxed to a '// &
    'reachable one. `modal_model` needs the points of `&response` or `&frequency_response`, at most 200, and at most 4000 '// &
    'modes.')

  type(input_name), parameter, public :: modes_names(*) = [ &
    input_name('modes', 'before', integer_input, '1', counts, swept=.true., excludes='tolerance', &
               meaning='modes of the beam alone, which the impact excites'), &
    input_name('modes', 'after', integer_input, '1', counts, swept=.true., excludes='tolerance', &
               meaning='modes of the beam with the captured mass'), &
    input_name('modes', 'tolerance', real_input, '1', number_range(1.0e-12_dp, coarsest_tolerance), swept=.true., &
               excludes='before after', meaning='largest error of histories over their peaks; sets counts'), &
    input_name('modes', 'modal_model', logical_input, default='.false.', &
               meaning='whether to add the modal model, for `beamwave-export`')]

contains

  pure subroutine complete_modes(modes, rebound, captured, lasting, response, messages)
    !! Fill in derived counts; report missing ones.
    type(group_values), intent(inout) :: modes
    logical, intent(in) :: rebound    !! an instantaneous impact without capture
    logical, intent(in) :: captured   !! or the beam changes later: there are several sets of modes
    logical, intent(in) :: lasting    !! finite contact, or no impact starts the motion: it converges
    logical, intent(in) :: response   !! histories are requested
    type(message_list), intent(inout) :: messages
    if (any(modes%values%given .and. .not. modes%values%known)) return
    if (modes%given('tolerance')) then
      if (rebound .or. .not. ((captured .or. lasting) .and. response)) call messages%add(modes%line_of('tolerance'), &
        'modes%tolerance', &
        'needs &response with &capture, &contact, &force, &base, &initial or a &body that comes, whose histories have such an '// &
        'error; accepted: counts, as before and after')
      return
    end if
    if (.not. (modes%given('before') .or. modes%given('after'))) then
      if (response .and. (captured .or. lasting) .and. .not. rebound) then
        call modes%derive('tolerance', default_tolerance, 0)
        return
      else if (response .and. rebound) then
        call messages%add(0, 'modes%before', 'is missing: &response with &impact and without &capture needs a count of modes, '// &
          'since the motion after a rebound depends on their number (its impulse tends to 0 as modes are added); accepted: 1 '// &
          'to '// &
          text_of(counts%high))
        return
      end if
      call modes%derive('before', real(default_count, dp), 0)
    end if
    if (.not. captured) then
      call complete_single(modes, messages)
    else if (.not. modes%given('after')) then        ! an omitted count equals the other one, and follows its sweep
      call modes%derive('after', modes%number('before'), modes%values(modes%at('before'))%sweeps(1))
    else if (.not. modes%given('before')) then
      call modes%derive('before', modes%number('after'), modes%values(modes%at('after'))%sweeps(1))
    end if
  end subroutine complete_modes

  pure subroutine complete_single(modes, messages)
    !! Check a scene without a capture: `after` may only repeat `before`, and is then dropped.
    type(group_values), intent(inout) :: modes
    type(message_list), intent(inout) :: messages
    if (.not. modes%given('after')) return
    if (.not. modes%given('before')) then
      call messages%add(modes%line_of('after'), 'modes%after', &
                        'without &capture there is one set of modes; accepted: its count as modes%before')
    else if (modes%number('after') /= modes%number('before')) then
      call messages%add(modes%line_of('after'), 'modes%after', 'is '//text_of(modes%whole('after'))// &
                        '; without &capture there is one set of modes; accepted: '// &
                        text_of(modes%whole('before'))//' as modes%before')
    end if
    call modes%drop('after')
  end subroutine complete_single

  pure type(modes_par) function build_modes(values) result(modes)
    !! Build the counts, or the tolerance.
    type(group_values), intent(in) :: values      !! complete
    modes%modal_model = values%values(values%at('modal_model'))%flag
    if (values%known('tolerance')) then
      modes%tolerance = values%number('tolerance')
      modes%asked = values%given('tolerance')
      modes%after = shown_modes
      return
    end if
    modes%before = values%whole('before')
    modes%after = modes%before
    if (values%known('after')) modes%after = values%whole('after')
  end function build_modes

  pure real(dp) function relaxed_tolerance(reached) result(tolerance)
    !! Return the finest of 0.5, 0.2, 0.1, 0.05 … that is safely above an achievable error; missing if none is.
    real(dp), intent(in) :: reached            !! estimated error of the displacement over its peak, > 0
    real(dp), parameter :: margin = 1.05_dp, steps(3) = [1.0_dp, 2.0_dp, 5.0_dp]
    real(dp) :: tens
    tolerance = missing
    if (margin*reached > coarsest_tolerance) return
    tens = 10.0_dp**(-floor(log10(margin*reached)))
    tolerance = minval([steps, 10.0_dp], mask=[steps, 10.0_dp] >= margin*reached*tens)/tens
  end function relaxed_tolerance

  pure logical function is_relaxed(modes)
    !! Return whether the default tolerance was out of reach and has been relaxed.
    type(modes_par), intent(in) :: modes
    is_relaxed = by_tolerance(modes) .and. .not. modes%asked .and. modes%tolerance /= default_tolerance
  end function is_relaxed

  pure real(dp) function wanted_tolerance(modes) result(tolerance)
    !! Return the tolerance; the default if modes are counted.
    type(modes_par), intent(in) :: modes
    tolerance = default_tolerance
    if (by_tolerance(modes)) tolerance = modes%tolerance
  end function wanted_tolerance

  pure logical function by_tolerance(modes)
    !! Return whether a tolerance determines how many modes are summed.
    type(modes_par), intent(in) :: modes
    by_tolerance = .not. is_missing(modes%tolerance)
  end function by_tolerance

end module bw_modes_par
