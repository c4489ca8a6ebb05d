module bw_hint
  !! The line of a report that names omitted effects: the absent effect that would change frequencies most, the decay
  !! that usual damping would cause, and the sensitivity to the place of a blow. These are estimates; `beamwave effects`
  !! runs both scenes. Nothing is ever switched on automatically.
  use bw_kinds, only: dp, i8
  use bw_absent_effects, only: absent_changes, absent_words
  use bw_beam_units, only: beam_units, units_of
  use bw_damping_par, only: usual_ratio
  use bw_error, only: error_type
  use bw_modes_par, only: wanted_tolerance
  use bw_scene, only: scene_type
  use bw_scene_cases, only: case_count, case_scene
  use bw_text, only: percent, shortest, text_of
  implicit none (type, external)
  private
  public :: estimate_absent, hint_line

  integer, parameter, public :: compared_modes = 10     !! number of first modes by which effects are judged

  type, public :: estimate_type
    !! The relative influence of an absent effect on frequencies; zero if it is present.
    integer :: effect = 0                !! its number
    integer :: mode = 0                  !! of the first `compared_modes`, the one changed most
    real(dp) :: change = 0.0_dp          !! of that mode
    integer :: last = 0                  !! the last mode examined
    real(dp) :: last_change = 0.0_dp     !! of the last mode
    logical :: steadies = .false.        !! mode 1 is unstable, and would be stable with the effect
  end type estimate_type

  type, public :: aside_type
    !! Other omissions of a scene.
    real(dp) :: left = 1.0_dp            !! fraction of the amplitude of mode 1 at the end of the record with usual damping
    integer :: mode = 0                  !! of the first `compared_modes`, the one most sensitive to the place of a captured mass
    real(dp) :: moved = 0.0_dp           !! the relative change of its frequency by `place_step`
  end type aside_type

  type :: remark_type
    !! One omission.
    real(dp) :: weight = 0.0_dp          !! its importance; of the first and last case of a sweep the larger is reported
    character(:), allocatable :: words
  end type remark_type

  real(dp), parameter :: place_step = 0.01_dp      !! of the length, inwards

contains

  function hint_line(scene) result(text)
    !! Return one line with its end; empty if no absent effect would change a frequency by more than the tolerance. In a
    !! sweep the first and last case are examined.
    type(scene_type), intent(in) :: scene
    character(:), allocatable :: text
    type(remark_type) :: found(size(absent_words) + 2), now(size(found))
    type(scene_type) :: one
    type(error_type), allocatable :: error
    real(dp) :: tolerance
    integer(i8) :: case
    integer :: i, r
    tolerance = wanted_tolerance(scene%modes)
    do i = 1, merge(1, 2, size(scene%sweeps) == 0)
      case = merge(1_i8, case_count(scene), i == 1)
      call case_scene(scene, case, one, error)
      if (allocated(error)) cycle
      tolerance = wanted_tolerance(one%modes)
      call find_remarks(one, now)
      do r = 1, size(found)
        if (now(r)%weight <= found(r)%weight) cycle
        found(r) = now(r)
        if (size(scene%sweeps) > 0) found(r)%words = now(r)%words//' in case '//text_of(case)
      end do
    end do
    text = frequency_words(found(:size(absent_words)), tolerance)
    do r = size(absent_words) + 1, size(found)
      if (found(r)%weight <= tolerance) cycle
      if (text /= '') text = text//'; '
      text = text//found(r)%words
    end do
    if (text /= '') text = '  left out   '//text//new_line('a')
  end function hint_line

  subroutine find_remarks(scene, remarks)
    !! Find the influence of absent effects, in the order of `absent_words`; then damping, and the place of a captured mass.
    type(scene_type), intent(in) :: scene          !! without sweeps
    type(remark_type), intent(out) :: remarks(:)
    type(estimate_type) :: estimates(size(absent_words))
    type(aside_type) :: aside
    real(dp), parameter :: nothing = 1.0e-4_dp     ! of an amplitude
    character(:), allocatable :: left
    integer :: e
    estimates = estimate_absent(scene, aside)
    do e = 1, size(estimates)
      remarks(e)%weight = weight(estimates(e))
      remarks(e)%words = words(estimates(e))
    end do
    remarks(e)%weight = 1.0_dp - aside%left
    left = 'hardly anything'
    if (aside%left > nothing) left = shortest(100.0_dp*aside%left, 2)//' %'
    remarks(e)%words = 'damping: a ratio of '//shortest(usual_ratio, 2)//' would leave '//left//' of mode 1 at the end'
    remarks(e + 1)%weight = abs(aside%moved)
    remarks(e + 1)%words = 'position: a mass '//shortest(100.0_dp*place_step, 2)//' % of the length further inward would '// &
      'change '// &
      change_words(aside%mode, aside%moved)
  end subroutine find_remarks

  pure function frequency_words(remarks, tolerance) result(text)
    !! Describe the two most important effects, if they matter.
    type(remark_type), intent(in) :: remarks(:)    !! in the order of `absent_words`
    real(dp), intent(in) :: tolerance
    character(:), allocatable :: text
    logical :: left(size(remarks))
    integer :: i, e
    text = ''
    left = .true.
    do i = 1, 2
      e = maxloc(remarks%weight, dim=1, mask=left)
      left(e) = .false.
      if (remarks(e)%weight <= tolerance) exit
      if (i == 2) text = text//'; '
      text = text//trim(absent_words(e))
      if (i == 1) text = text//' would matter most'
      text = text//': '//remarks(e)%words
    end do
    if (text /= '') text = text//' (frequencies, estimated)'
  end function frequency_words

  function estimate_absent(scene, aside) result(estimates)
    !! Estimate absent effects, in the order of `absent_words`.
    type(scene_type), intent(in) :: scene          !! without sweeps
    type(aside_type), intent(out), optional :: aside
    type(estimate_type) :: estimates(size(absent_words))
    real(dp), allocatable :: change(:, :), square(:), inward(:)
    integer :: i, n, last
    last = scene%modes%before
    if (allocated(scene%capture) .or. last == 0) last = scene%modes%after
    n = min(compared_modes, last)
    allocate (change(n + 1, size(absent_words)), square(n + 1), inward(n + 1))
    call absent_changes(scene, [(i, i=1, n), last], change, estimates%steadies, square, inward)
    if (present(aside)) then
      aside%left = damped_part(scene, square(1))
      aside%mode = maxloc(abs(inward(:n)), dim=1)
      aside%moved = place_step*inward(aside%mode)
    end if
    do i = 1, size(estimates)
      estimates(i)%effect = i
      estimates(i)%mode = maxloc(abs(change(:n, i)), dim=1)
      estimates(i)%change = change(estimates(i)%mode, i)
      estimates(i)%last = last
      estimates(i)%last_change = change(n + 1, i)
    end do
  end function estimate_absent

  pure real(dp) function damped_part(scene, square) result(part)
    !! Return the fraction of the amplitude of mode 1 at the end of the record with the usual damping ratio: e^(−ζβT). 1
    !! if the scene has damping, nothing moves, or the mode is unstable.
    type(scene_type), intent(in) :: scene          !! without sweeps
    real(dp), intent(in) :: square                 !! β² of mode 1
    type(beam_units) :: units
    part = 1.0_dp
    if (allocated(scene%damping) .or. .not. (allocated(scene%response) .and. allocated(scene%impact))) return
    if (scene%impact%mass_ratio == 0.0_dp .or. scene%impact%approach_velocity == 0.0_dp) return
    units = units_of(scene%beam)
    part = exp(-usual_ratio*sqrt(max(0.0_dp, square))*(scene%response%duration/units%time%hi))
  end function damped_part

  elemental real(dp) function weight(estimate)
    !! Weigh an estimate; stabilising a mode weighs more than any change.
    type(estimate_type), intent(in) :: estimate
    weight = abs(estimate%change)
    if (estimate%steadies) weight = huge(weight)
  end function weight

  pure function words(estimate) result(text)
    !! Describe the influence of an effect on the mode changed most, and on the last one if that is larger.
    type(estimate_type), intent(in) :: estimate
    character(:), allocatable :: text
    text = ''
    if (estimate%steadies) text = 'mode 1 would be stable'
    if (estimate%change /= 0.0_dp .and. estimate%steadies) text = text//', '
    if (estimate%change /= 0.0_dp) text = text//change_words(estimate%mode, estimate%change)
    if (estimate%last > estimate%mode .and. abs(estimate%last_change) > abs(estimate%change)) &
      text = text//', '//change_words(estimate%last, estimate%last_change)
  end function words

  pure function change_words(mode, change) result(text)
    !! Describe the change of a mode; one that loses all its frequency becomes unstable.
    integer, intent(in) :: mode
    real(dp), intent(in) :: change               !! relative
    character(:), allocatable :: text
    text = 'mode '//text_of(mode)//' '//percent(change)//' %'
    if (change <= -1.0_dp) text = 'mode '//text_of(mode)//' would be unstable'
  end function change_words

end module bw_hint
