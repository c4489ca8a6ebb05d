module bw_sensor_waves
  !! Waves along a beam from the complex amplitudes of lines at two or more sensors: wave number and phase velocity of each line
  !! from its shape at the sensors, group velocity, √(EI/ρA) and ω from the dispersion of all lines.
  use bw_kinds, only: dp
  use bw_missing, only: is_missing, missing
  use bw_monitor, only: monitor_type
  use bw_note, only: remark
  use bw_quantile, only: normal, squares_deviation, student_quantile
  use bw_sensor_lines, only: hertz, measured_lines, sensor_facts, sensor_waves, square_of
  use bw_separation, only: separation_of
  use bw_shape_fit, only: wave_candidate, candidates_of, costs_of, fits_anything, freedom_of, interval_of, motion_type, &
    & reason_against, rounding, scanned, wave_sensor, worse
  use bw_text, only: append, shortest, string
  use bw_wave_candidates, only: choice_type, possible_tips
  use bw_wave_choice, only: choose_waves
  use bw_wave_velocities, only: fill_dispersion, fill_waves, unlikely, wave_type
  implicit none (type, external)
  private
  public :: measure_sensor_waves

  real(dp), parameter :: seen = 3              !! standard deviations by which a line must exceed the noise at some sensor
  real(dp), parameter :: vague = 0.5_dp        !! largest relative error of a wave number that is reported
  real(dp), parameter :: lopsided = 1.5_dp     !! ratio of the two sides of an interval above which the longer one is the error
  real(dp), parameter :: linear = 0.02_dp      !! relative; larger deviations of α are taken from the profile of the misfit
  real(dp), parameter :: low = 3               !! largest α of a first mode
  real(dp), parameter :: unknown = 3           !! standard deviation of an α that may be any from 0 up
  real(dp), parameter :: usual = 0.95_dp       !! confidence at which quantiles of Student's distribution become normal ones

contains

  subroutine measure_sensor_waves(facts, lines, waves, monitor)
    !! Measure the waves that the sensors determine, and note why others are missing.
    type(sensor_facts), intent(in) :: facts
    type(measured_lines), intent(in) :: lines
    type(sensor_waves), intent(out) :: waves
    class(monitor_type), intent(inout), optional :: monitor    !! results are undefined after a stop request
    type(wave_sensor) :: sensors
    type(choice_type) :: choices(size(lines%angular_frequency))
    type(motion_type) :: motions(size(choices))
    type(wave_type) :: found(size(choices))
    character(:), allocatable :: reason
    logical :: agree(size(choices))
    integer :: k
    call start(size(choices), waves)
    if (size(choices) == 0) return
    sensors%position = facts%position
    sensors%strain = [(facts%quantity(k)%text == 'strain', k=1, size(facts%quantity))]
    sensors%ends = facts%ends
    sensors%model = facts%model
    reason = reason_against(sensors)
    if (.not. facts%length > 0) reason = 'the length of the beam, the unit of the positions, is not given (&beam)'
    if (reason /= '') then
      call remark(waves%notes, 'wave numbers and velocities are missing, since '//reason)
      return
    end if
    call find_motions(facts, lines, motions)
    call find_choices(sensors, motions, square_of(lines), facts, choices, monitor)
    do k = 1, size(choices)
      call find_wave(facts, sensors, motions(k), choices(k), found(k), reason)
      if (reason /= '') call remark(waves%notes, 'the line at '//hertz(lines, k)//' has no wave number: '//reason)
    end do
    call note_misfits(facts, lines, choices%misfits .and. found%exists, waves%notes)
    call fill_waves(facts, lines, found, waves)
    call fill_dispersion(facts, lines, found, choices%on_curve .and. found%exists, waves, agree)
    if (facts%simulated) return
    call compare_with_beam(facts, lines, fits_anything(sensors) .or. sensors%ends == 'model' &
      & .or. any(choices%misfits .and. found%exists), waves)
    if (fits_anything(sensors)) call remove_intervals(lines, found%exists .and. .not. agree, waves)
  end subroutine measure_sensor_waves

  pure subroutine start(count, waves)
    !! Set all values to `missing`.
    integer, intent(in) :: count
    type(sensor_waves), intent(inout) :: waves
    real(dp) :: none(count)
    none = missing
    allocate (waves%wavenumber, waves%wavenumber_error, waves%phase_velocity, waves%phase_velocity_error, &
      & waves%group_velocity, waves%group_velocity_error, source=none)
    allocate (waves%notes(0))
  end subroutine start

  subroutine find_motions(facts, lines, motions)
    !! Amplitudes of displacement, or strain, over their standard deviations: velocity is −δ + iβ times displacement, acceleration
    !! (−δ + iβ)² times it. Standard deviations are at least rounding; if one is unknown, all are equal fractions of the
    !! largest amplitude of their quantity.
    type(sensor_facts), intent(in) :: facts
    type(measured_lines), intent(in) :: lines
    type(motion_type), intent(out) :: motions(:)
    complex(dp), dimension(size(facts%position)) :: factor, motion
    real(dp), dimension(size(facts%position)) :: largest, deviation
    integer :: k, s
    do k = 1, size(motions)
      do s = 1, size(factor)
        factor(s) = factor_of(facts%quantity(s)%text, cmplx(-lines%decay_rate(k), lines%angular_frequency(k), dp))
      end do
      motion = lines%amplitude(:, k)/factor
      deviation = lines%deviation(:, k)/abs(factor)
      do s = 1, size(factor)
        largest(s) = tiny(1.0_dp)/epsilon(1.0_dp) &
          & + maxval(max(abs(motion%re), abs(motion%im)), mask=is_like(facts%quantity(s)%text))
      end do
      motions(k)%freed = any(.not. deviation > 0)
      if (motions(k)%freed) deviation = largest
      motions(k)%weight = 1/max(deviation, rounding*largest)
      motions(k)%data = motion*motions(k)%weight
      motions(k)%weight = scale(motions(k)%weight, -exponent(maxval(motions(k)%weight)))
      if (motions(k)%freed .or. .not. allocated(lines%correlation)) cycle
      factor = factor/abs(factor)
      motions(k)%separating = separation_of(reshape([(real(lines%correlation(:, s, k)*conjg(factor)*factor(s)), &
        & s=1, size(factor))], shape(lines%correlation(:, :, k))))
      motions(k)%data = matmul(motions(k)%separating, motions(k)%data)
    end do

  contains

    pure complex(dp) function factor_of(quantity, pole)
      !! The ratio of a quantity to displacement; 1 for strain.
      character(*), intent(in) :: quantity
      complex(dp), intent(in) :: pole
      factor_of = 1
      if (quantity == 'velocity') factor_of = pole
      if (quantity == 'acceleration') factor_of = pole**2
    end function factor_of

    pure function is_like(quantity)
      !! The sensors that measure a quantity.
      character(*), intent(in) :: quantity
      logical :: is_like(size(facts%quantity))
      integer :: i
      is_like = [(facts%quantity(i)%text == quantity, i=1, size(facts%quantity))]
    end function is_like

  end subroutine find_motions

  subroutine find_choices(sensors, motions, square, facts, choices, monitor)
    !! Find the candidates for each line's wave number and how well its shape fits, and choose among them.
    type(wave_sensor), intent(in) :: sensors
    type(motion_type), intent(in) :: motions(:)
    real(dp), intent(in) :: square(:)          !! β², (line)
    type(sensor_facts), intent(in) :: facts
    type(choice_type), intent(inout) :: choices(:)
    class(monitor_type), intent(inout), optional :: monitor
    type(wave_candidate), allocatable :: candidates(:)
    real(dp), allocatable :: alpha(:), misfit(:, :)
    real(dp) :: least
    logical :: scaled
    integer :: k, freedom
    freedom = freedom_of(sensors)
    call scanned(sensors, motions, alpha, misfit)
    do k = 1, size(choices)
      allocate (choices(k)%candidates(0))
      if (.not. exceeds_noise(motions(k))) cycle
      candidates = candidates_of(sensors, motions(k), alpha, misfit(:, k), freedom)
      call widen(sensors, motions(k), freedom, candidates)
      if (sensors%ends == 'tip') candidates = possible_tips(candidates)
      if (size(candidates) == 0) cycle
      least = minval(candidates%misfit)
      choices(k)%misfits = .not. motions(k)%freed .and. squares_deviation(least, freedom) > unlikely
      scaled = motions(k)%freed .or. choices(k)%misfits
      if (scaled) choices(k)%scale = sqrt(least/freedom + rounding**2)
      if (scaled) choices(k)%freedom = freedom
      candidates%cost = costs_of(candidates%misfit, least, freedom, scaled)
      choices(k)%candidates = pack(candidates, candidates%cost <= worse)
      choices(k)%candidates%deviation = choices(k)%candidates%deviation*choices(k)%scale &
        & *student_quantile(usual, choices(k)%freedom)/student_quantile(usual, normal)
    end do
    call choose_waves(square, facts%rotates, sensors%ends == 'tip', facts%alone, choices, monitor)
    where (choices%chosen > 0 .and. .not. choices%on_curve .and. count(choices%on_curve) > 1 .and. fits_anything(sensors)) &
      & choices%chosen = 0
  end subroutine find_choices

  subroutine widen(sensors, motion, freedom, candidates)
    !! Take the standard deviation of long waves from the profile of the misfit, since linear theory is poor where sensors see
    !! little of a wave.
    type(wave_sensor), intent(in) :: sensors
    type(motion_type), intent(in) :: motion
    integer, intent(in) :: freedom
    type(wave_candidate), intent(inout) :: candidates(:)
    real(dp) :: variance, quantile
    integer :: i
    quantile = student_quantile(usual, normal)
    variance = minval(candidates%misfit)/freedom
    if (.not. motion%freed) variance = max(1.0_dp, variance)
    do i = 1, size(candidates)
      associate (candidate => candidates(i))
        if (candidate%alpha > low .or. candidate%deviation*sqrt(variance) <= linear*candidate%alpha) cycle
        candidate%deviation = max(candidate%deviation, min(unknown, maxval(abs(candidate%alpha - &
          & interval_of(sensors, motion, candidate, quantile**2*variance))))/quantile/sqrt(variance))
      end associate
    end do
  end subroutine widen

  pure logical function exceeds_noise(motion)
    !! Whether the line exceeds the noise at some sensor.
    type(motion_type), intent(in) :: motion
    exceeds_noise = motion%freed .or. any(abs(motion%data) > seen)
  end function exceeds_noise

  subroutine find_wave(facts, sensors, motion, choice, wave, reason)
    !! Find the wave number and the interval of its profile likelihood, or the reason why there is none.
    type(sensor_facts), intent(in) :: facts
    type(wave_sensor), intent(in) :: sensors
    type(motion_type), intent(in) :: motion
    type(choice_type), intent(in) :: choice
    type(wave_type), intent(inout) :: wave
    character(:), allocatable, intent(out) :: reason
    real(dp) :: interval(2), sides(2), quantile
    reason = ''
    if (.not. exceeds_noise(motion)) then
      reason = 'all sensors are near its nodes'
    else if (size(choice%candidates) == 0) then
      reason = 'no mass at the tip gives such a shape'
    else if (choice%chosen == 0 .and. choice%rival == 0) then
      reason = 'it is not on the dispersion curve of the other lines, which so few sensors require'
    else if (choice%chosen == 0) then
      associate (pair => choice%candidates([choice%best, choice%rival])%alpha/facts%length)
        reason = shortest(pair(1), 4)//' and '//shortest(pair(2), 4)//' 1/m fit equally well'
      end associate
    end if
    if (reason /= '') return
    wave%alpha = choice%candidates(choice%chosen)%alpha
    quantile = student_quantile(facts%confidence, choice%freedom)
    interval = interval_of(sensors, motion, choice%candidates(choice%chosen), (quantile*choice%scale)**2)
    sides = abs(interval - wave%alpha)
    wave%error = merge(maxval(sides), sum(sides/2), maxval(sides) > lopsided*minval(sides)) + rounding*wave%alpha
    wave%deviation = wave%error/student_quantile(facts%confidence, normal)
    wave%exists = wave%error <= vague*wave%alpha
    if (.not. wave%exists) reason = 'the sensors do not determine it: '//shortest(wave%alpha/facts%length, 2)// &
      & ' 1/m fits best, but half and twice as much are not excluded'
  end subroutine find_wave

  pure subroutine compare_with_beam(facts, lines, doubtful, waves)
    !! Note if √(EI/ρA) of the waves is not the beam's. A flexible root looks like a longer beam, and so like another √(EI/ρA):
    !! if the sensors do not confirm the ends, or the ends assume the beam's EI, intervals are widened to the waves of the beam.
    type(sensor_facts), intent(in) :: facts
    type(measured_lines), intent(in) :: lines
    logical, intent(in) :: doubtful            !! the ends are not confirmed: few sensors, shapes that do not fit, or 'model'
    type(sensor_waves), intent(inout) :: waves
    real(dp) :: difference(size(waves%wavenumber))
    character(:), allocatable :: words
    if (is_missing(waves%stiffness_root) .or. .not. facts%stiffness_root > 0) return
    if (abs(waves%stiffness_root - facts%stiffness_root) <= waves%stiffness_root_error*unlikely/ &
      & student_quantile(facts%confidence, normal)) return
    words = 'sqrt(EI/(rho A)) of the waves, '//shortest(waves%stiffness_root, 5)//' m2/s, differs from '// &
      & 'that of the scene, '//shortest(facts%stiffness_root, 5)//', by more than its error: the material, section, length or '// &
      & 'ends are not those of the scene'
    if (doubtful) words = words//'; intervals are widened to hold both'
    call append(waves%notes, words)
    if (.not. doubtful) return
    difference = abs(sqrt(sqrt(square_of(lines) + facts%angular_velocity**2)/facts%stiffness_root)/waves%wavenumber - 1)
    where (.not. is_missing(waves%wavenumber))
      waves%wavenumber_error = waves%wavenumber_error + difference*waves%wavenumber
      waves%phase_velocity_error = waves%phase_velocity_error + difference*waves%phase_velocity
    end where
    where (.not. is_missing(waves%group_velocity)) &
      & waves%group_velocity_error = waves%group_velocity_error + difference*waves%group_velocity
    waves%stiffness_root_error = waves%stiffness_root_error + abs(waves%stiffness_root - facts%stiffness_root)
  end subroutine compare_with_beam

  pure subroutine remove_intervals(lines, refused, waves)
    !! Remove the intervals of waves that depend on the assumed ends: so few sensors fit any shape, and no other line confirms
    !! that the wave number lies on the beam's dispersion.
    type(measured_lines), intent(in) :: lines
    logical, intent(in) :: refused(:)          !! (line)
    type(sensor_waves), intent(inout) :: waves
    character(:), allocatable :: words
    integer :: k
    if (.not. any(refused)) return
    where (refused)
      waves%wavenumber_error = missing
      waves%phase_velocity_error = missing
      waves%group_velocity_error = missing
    end where
    if (all(is_missing(waves%wavenumber_error))) then
      waves%stiffness_root_error = missing
      waves%angular_velocity_error = missing
    end if
    words = ''
    do k = 1, size(refused)
      if (refused(k)) words = words//', '//hertz(lines, k)
    end do
    call remark(waves%notes, 'no intervals, since so few sensors fit any beam and no other line confirms '// &
      & 'the dispersion; one more sensor would test the assumed ends: '//words(3:))
  end subroutine remove_intervals

  pure subroutine note_misfits(facts, lines, misfits, notes)
    !! Note the lines whose shapes the ends do not allow.
    type(sensor_facts), intent(in) :: facts
    type(measured_lines), intent(in) :: lines
    logical, intent(in) :: misfits(:)          !! (line)
    type(string), allocatable, intent(inout) :: notes(:)
    character(:), allocatable :: words
    integer :: k
    words = ''
    do k = 1, size(misfits)
      if (misfits(k)) words = words//', '//hertz(lines, k)
    end do
    if (words /= '') call append(notes, 'these shapes differ by more than the noise from those of a uniform '// &
      & 'beam with ends = '''//facts%ends//''', and their intervals are widened: '//words(3:))
  end subroutine note_misfits

end module bw_sensor_waves
